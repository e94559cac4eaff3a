"""Routes: the scenes at hand."""

from __future__ import annotations

import math

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.scenes import (
    ControlOut,
    EventOut,
    FieldOut,
    OptionOut,
    PerceptionOut,
    SceneOut,
    SignalOut,
)
from evastudio.api.paging import NamedPage
from evastudio.live.headless import make_scene, scenes
from evastudio.motion.peopled import Peopled
from evastudio.world.scene import Scene
from evastudio.world.spaces import Box, Symbols

router = APIRouter(prefix="/scenes", tags=["scenes"])


@router.get("")
def list_scenes(studio: Studio, paging: NamedPage) -> Page[SceneOut]:
    """Every scene, with its options, controls and perceptions."""
    return paging.page(
        scenes(studio.workspace), lambda kind: kind.name, lambda kind: _scene(kind())
    )


@router.get("/{name}")
def get_scene(name: str, studio: Studio) -> SceneOut:
    """One scene."""
    return _scene(make_scene(studio.workspace, name))


def _scene(scene: Scene) -> SceneOut:
    chosen = scene.chosen(scene.perception())
    return SceneOut(
        name=scene.name,
        title=scene.title,
        version=scene.version,
        dt_s=scene.dt_s,
        outcomes=list(scene.outcomes),
        successes=sorted(scene.successes),
        options=[OptionOut.model_validate(option) for option in scene.options],
        controls=[
            ControlOut(
                field=control.field,
                label=control.label,
                negative=control.negative,
                positive=control.positive,
                ramp_s=control.ramp_s,
                reach=control.reach,
            )
            for control in scene.controls
        ],
        signals=[
            SignalOut(
                name=signal.name,
                label=signal.label,
                key=signal.key,
                placed=signal.place is not None,
            )
            for signal in scene.signals
        ],
        events=[
            EventOut(name=sign.name, label=sign.label) for sign in scene.signs if sign.unit is None
        ],
        action=_fields(scene.action) if isinstance(scene.action, Box) else [],
        symbols=list(chosen.names) if isinstance(chosen, Symbols) else [],
        many=bool(scene.characters),
        perceptions=[
            PerceptionOut(name=view.name, summary=view.summary, state=_fields(view.state))
            for view in scene.perceptions.values()
        ],
        people=isinstance(scene, Peopled),
    )


def _fields(box: Box) -> list[FieldOut]:
    return [
        FieldOut(name=field.name, unit=field.unit, low=_bound(field.low), high=_bound(field.high))
        for field in box.fields
    ]


def _bound(value: float) -> float | None:
    return value if math.isfinite(value) else None
