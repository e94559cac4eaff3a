"""Lineups over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from evastudio.api.models.common import Given, Model, Name, Options, Seed


class EntrantIn(Given):
    """Somebody to be shown: a pilot or a take."""

    pilot: Name | None = None
    """A policy, or another pilot of the scene."""
    take: int | None = None
    """A take, as it was recorded. All are then shown in its world."""


class LineupIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "scene": "asteroids",
                    "options": {"density": 0.5},
                    "entrants": [{"pilot": "asteroids-careful"}, {"pilot": "straight"}],
                }
            ]
        }
    )

    scene: Name
    options: Options
    seed: Seed = 0
    """Of a series of worlds, as that of an evaluation."""
    world: Annotated[int, Field(ge=0, lt=100_000)] = 0
    """Which of the series, from 0."""
    entrants: Annotated[list[EntrantIn], Field(min_length=2, max_length=4)]


class HappeningOut(Model):
    seconds: float
    kind: str
    """'sign', 'near' or 'outcome'."""
    says: str


class ColumnOut(BaseModel):
    view: str
    """Path of its 3D view."""
    title: str
    """Who it is; of a ballot's only on which side it is."""
    length_s: float
    outcome: str | None
    """What became of it; None where it still went on when the longest that is shown was over."""
    success: bool | None
    parts_s: float | None
    """When it is no longer where the first column is; None where it is to the end."""
    happenings: list[HappeningOut]


class StandingOut(Model):
    position_s: float
    speed: float
    """How fast it goes on; 0 where it stands."""
    camera: str
    turned: bool
    """Whether a person turned the cameras from where the scene has them."""


class LineupOut(BaseModel):
    id: str
    scene: str
    dt_s: float
    length_s: float
    """Of the longest of them."""
    parts_s: float | None
    """The first moment at which they are not all in one place; None where there is none."""
    cameras: Sequence[str]
    columns: list[ColumnOut]
    options: Mapping[str, float]
    world: int
    """Which of its series."""
    ballot: int | None
    """The one it is shown for."""
    standing: StandingOut


class LineupCommandIn(Given):
    """What a person does with all columns at once."""

    name: Literal["seek", "roll", "camera"]
    seconds: Annotated[float, Field(ge=0, le=86_400)] = 0.0
    """Where to look."""
    speed: FiniteFloat = 1.0
    """How fast to go on: 0 stands, below 0 goes back."""
    camera: Name | None = None
    """Of the scene's cameras; where none is named the present one, as the scene has it."""
