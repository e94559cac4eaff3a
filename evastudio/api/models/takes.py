"""Takes over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, FiniteFloat

from evastudio.api.models.common import Given, Model, Name, Options, Seed, at_most
from evastudio.demonstrations.names import NOTE_LENGTH
from evastudio.live.enacting import MOST_STEPS

Step = Annotated[int, Field(ge=0, lt=2**31)]
Row = Annotated[list[FiniteFloat], Field(min_length=1, max_length=64)]
Rows = Annotated[list[Row], Field(min_length=1), at_most(MOST_STEPS)]
Crowd = Annotated[
    list[Annotated[list[Row], Field(min_length=1), at_most(10_000)]],
    Field(min_length=1),
    at_most(MOST_STEPS),
]


class OriginOut(Model):
    step: int
    """The decision of that run before which the take goes on."""
    seconds: float
    """The same, since that run began."""
    take: int | None
    """The take that it forks from, or whose end it is; null where the run was not recorded."""
    number: int | None = None
    """Of that take in its session; null where it is there no more."""
    policy: str | None
    """The policy that a person took over from: the take corrects it."""


class RemarkOut(Model):
    kind: Literal["short", "still", "held", "early", "unlike"]
    says: str


class RemarkedOut(Model):
    take: int
    remarks: list[RemarkOut]


class RemarksOut(Model):
    items: list[RemarkedOut]
    """The takes to look at again, the newest first."""


class NoteIn(Given):
    note: Annotated[str, Field(max_length=NOTE_LENGTH)]
    """Empty to take the note away."""


class TakeOut(Model):
    id: int
    session: int
    number: int
    """Its place in the session, from 1."""
    scene_version: int
    seed: int
    """Of its world; -1 where the world was recorded elsewhere."""
    options: Mapping[str, float]
    pilot: str
    pairs: int
    seconds: float
    outcome: str | None
    """None while it is being recorded, and where it was broken off."""
    started_at: float
    """Seconds since the epoch."""
    trashed: bool
    origin: OriginOut | None
    """What it goes on from, where that is no new world."""
    note: str
    """What a person noted of it."""


class TakeIn(Given):
    model_config = ConfigDict(json_schema_extra={"examples": [{"seed": 7, "pilot": "steady"}]})

    pilot: Annotated[str, Field(min_length=1, max_length=80)] = "program"
    """Who acts, for people who read the list of takes."""
    seed: Seed | None = None
    """Of the world; any where none is given."""
    options: Options
    perception: Name | None = None
    """Through which the states are kept that are answered; the scene's first where none is named.
    Snapshots are kept too, so a policy can be fitted under another one."""


class ActionsIn(Given):
    first_step: Step
    """The step that the first action is for: how many the take has so far."""
    actions: Rows | Crowd
    """One row for each step, in the world's frame; of many characters the lead's alone, or a list
    of rows, one for each."""
    states: Rows | None = None
    """What the program saw before each action. Compared with what there was, where given."""


class StandingOut(Model):
    take: int
    pairs: int
    """Steps written; the next actions begin with this one."""
    accepted: int
    """Of the actions given, how many are in the take; fewer where the world ended before."""
    closed: bool
    outcome: str | None
    """How the world ended, computed by the scene; None where it has not."""
    state: list[float]
    """What the character perceives now, under the take's perception."""


class EmptiedOut(Model):
    takes: int
    """How many were deleted for good."""


class RecordingOut(Model):
    take: int
    seed: int
    states: list[list[float]]
    """What was perceived at each step."""
    actions: list[list[float]] | list[list[list[float]]]
    """What was done then, in the world's frame; of many characters that of all."""
