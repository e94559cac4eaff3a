"""Headless worlds over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat

from evastudio.api.models.common import Given, Model, Name, Options, Seed, at_most
from evastudio.live.batch import MOST_STEPS, MOST_WORLDS
from evastudio.live.worlds import PROGRAM

Seeds = Annotated[list[Seed], Field(min_length=1), at_most(MOST_WORLDS)]
Numbers = Annotated[list[FiniteFloat], at_most(10_000)]
Rows = Annotated[list[Numbers], at_most(MOST_STEPS)]
Blocks = Annotated[list[Rows], at_most(MOST_STEPS)]
Steps = Annotated[list[Blocks], at_most(MOST_STEPS)]


class WorldsIn(Given):
    scene: Name
    seeds: Seeds
    """One world for each, the same as anywhere else in the studio."""
    options: Options
    perception: Name | None = None
    """What states are of; the scene's first where none is named."""
    session: Annotated[int, Field(ge=1)] | None = None
    """What the program does in the one world becomes takes of this session."""
    pilot: Annotated[str, Field(min_length=1, max_length=80)] = PROGRAM
    """The program's name; its takes say that it is a program's."""


class ResetIn(Given):
    seeds: Seeds


class StepIn(Given):
    actions: Rows | Blocks | Steps
    """(worlds, m) or (steps, worlds, m); where many act (worlds, characters, m) or (steps, worlds,
    characters, m), or (worlds, m) for the leads alone while the others rest."""


class PlayIn(Given):
    pilot: Name
    """A policy or another pilot of the studio."""
    steps: Annotated[int, Field(ge=1, le=MOST_STEPS)] = 1


class SeenOut(Model):
    states: list[list[float]] | list[list[list[float]]]
    """What is perceived now, (worlds, n), or of everybody, (worlds, characters, n)."""
    outcomes: list[str]
    """What has become of each world; the first of the scene's outcomes while it runs."""
    progress: list[float]
    """How far each has come, 0 to 1."""
    steps: list[int]
    """Decisions taken in each."""
    ended: bool
    """Whether all have."""


class DemonstratingOut(Model):
    session: int
    pilot: str
    pairs: int
    """Of the running take, or of the last one."""
    problem: str | None
    """Why saving does not work at the moment, or None."""


class WorldsOut(Model):
    id: str
    scene: str
    scene_version: int
    options: dict[str, float]
    perception: str
    seeds: list[int]
    characters: int | None
    """How many act in each world; None where one acts alone."""
    dt_s: float
    """The decision step, seconds."""
    outcomes: list[str]
    """By their code; the first while a world runs."""
    state: list[str]
    """The names of its components; the scene's description tells units and ranges."""
    action: list[str]
    """Likewise, in the world's frame."""
    own_action: list[str]
    """Likewise, in the perception's frame; where that is a choice among symbols, one code."""
    symbols: list[str]
    """What the codes of own actions mean; empty where they are numbers."""
    demonstrating: DemonstratingOut | None
    idle_s: float
    """Nobody having asked for it for so long, it closes itself."""
    socket: str
    """Path of the websocket for many steps a second."""
