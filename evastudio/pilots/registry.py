"""Pilots by name."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from evastudio.errors import not_found
from evastudio.pilots.scripted import ScriptedPilot
from evastudio.pilots.straight import StraightPilot
from evastudio.pilots.traits import STYLES, Traits
from evastudio.world.rollout import Pilot


def pilot_names() -> list[str]:
    """Every name that `find_pilot` answers to."""
    return [StraightPilot.name, *(f"scripted:{style}" for style in STYLES)]


def find_pilot(name: str, **traits: Any) -> Pilot:
    """The pilot of that name, with `traits` (fields of `Traits`) changed where it is scripted.

    Raises NotFoundError for an unknown pilot or trait, InvalidInputError for a bad value.
    """
    if name not in pilot_names():
        raise not_found("pilot", name, pilot_names())
    known = [] if name == StraightPilot.name else [field.name for field in fields(Traits)]
    for trait in traits:
        if trait not in known:
            raise not_found(f"trait of pilot {name!r}", trait, known)
    if name == StraightPilot.name:
        return StraightPilot()
    style = STYLES[name.removeprefix("scripted:")]
    return ScriptedPilot(replace(style, **traits), name)
