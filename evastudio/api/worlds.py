"""Routes: headless worlds, in which another program demonstrates, plays or tries."""

from __future__ import annotations

import asyncio
import contextlib
import time

from fastapi import APIRouter, status

from evastudio.api.context import Context, Studio
from evastudio.api.models.common import Page
from evastudio.api.models.worlds import (
    DemonstratingOut,
    PlayIn,
    ResetIn,
    SeenOut,
    StepIn,
    WorldsIn,
    WorldsOut,
)
from evastudio.errors import StudioError
from evastudio.live.batch import Batch
from evastudio.live.stepping import Seen
from evastudio.live.worlds import IDLE_S
from evastudio.world.spaces import Space, Symbols

router = APIRouter(prefix="/worlds", tags=["worlds"])


@router.post("", status_code=status.HTTP_201_CREATED)
async def open_worlds(body: WorldsIn, studio: Studio) -> WorldsOut:
    """New worlds, one for each seed. They close themselves when nobody asks for them any more."""
    batch = await asyncio.to_thread(studio.worlds.open, **body.model_dump())
    studio.background(_close_when_idle(batch, studio))
    return _described(batch)


@router.get("")
def list_worlds(studio: Studio) -> Page[WorldsOut]:
    """The batches that are open, the first opened first."""
    return Page(items=[_described(batch) for batch in studio.worlds.all()])


@router.get("/{worlds}")
def get_worlds(worlds: str, studio: Studio) -> WorldsOut:
    """What a batch is of."""
    return _described(studio.worlds.get(worlds))


@router.get("/{worlds}/state")
def observe_worlds(worlds: str, studio: Studio) -> SeenOut:
    """How the worlds are now."""
    batch = studio.worlds.get(worlds)
    return _seen(batch, batch.observe())


@router.post("/{worlds}/reset")
def reset_worlds(worlds: str, body: ResetIn, studio: Studio) -> SeenOut:
    """New worlds in place of those there are, of any number; a running take is kept as it is."""
    batch = studio.worlds.get(worlds)
    return _seen(batch, batch.reset(body.seeds))


@router.post("/{worlds}/step")
def step_worlds(worlds: str, body: StepIn, studio: Studio) -> SeenOut:
    """One decision in every world, or several one after another."""
    batch = studio.worlds.get(worlds)
    return _seen(batch, batch.step(body.actions, own=body.frame == "own"))


@router.post("/{worlds}/play")
def play_worlds(worlds: str, body: PlayIn, studio: Studio) -> SeenOut:
    """Let a policy, or another pilot of the studio, decide for some steps; none is recorded."""
    batch = studio.worlds.get(worlds)
    return _seen(batch, batch.play(body.pilot, body.steps))


@router.delete("/{worlds}", status_code=status.HTTP_204_NO_CONTENT)
def close_worlds(worlds: str, studio: Studio) -> None:
    """Let go of the worlds; a running take is kept as it is, and is in the store by the answer."""
    studio.worlds.close(worlds)


async def _close_when_idle(batch: Batch, studio: Context) -> None:
    while (left := batch.used_at + IDLE_S - time.monotonic()) > 0.0:
        await asyncio.sleep(left)
    with contextlib.suppress(StudioError):  # closed by somebody, or the log tells
        await asyncio.to_thread(studio.worlds.close, batch.name)


def _described(batch: Batch) -> WorldsOut:
    scene, demonstration = batch.scene, batch.demonstration
    chosen = scene.chosen(batch.view)
    return WorldsOut(
        id=batch.name,
        scene=scene.name,
        scene_version=scene.version,
        options=dict(scene.values),
        perception=batch.view.name,
        seeds=list(batch.seeds),
        characters=scene.characters[0] if scene.characters else None,
        dt_s=scene.dt_s,
        outcomes=list(scene.outcomes),
        state=_names(batch.view.state),
        action=_names(scene.action),
        own_action=_names(chosen),
        symbols=list(chosen.names) if isinstance(chosen, Symbols) else [],
        demonstrating=None
        if demonstration is None
        else DemonstratingOut(
            session=demonstration.session.id,
            pilot=demonstration.pilot,
            pairs=demonstration.pairs,
            problem=demonstration.problem,
        ),
        idle_s=IDLE_S,
        socket=f"/api/v1/worlds/{batch.name}/socket",
    )


def _names(space: Space) -> list[str]:
    return ["symbol"] if isinstance(space, Symbols) else list(space.names)


def _seen(batch: Batch, seen: Seen) -> SeenOut:
    return SeenOut(
        states=seen.states.tolist(),
        outcomes=[batch.scene.outcomes[code] for code in seen.outcomes],
        progress=seen.progress.tolist(),
        steps=seen.steps.tolist(),
        ended=bool(seen.outcomes.all()),
    )
