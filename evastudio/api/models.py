"""What travels over HTTP, field by field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Generic, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

T = TypeVar("T")
Delay = Annotated[float, Field(ge=0.0, le=2.0)] | Literal["auto", "off"]
"""Reaction delay to take out: as estimated where that helps, none, or so many seconds."""
Name = Annotated[str, Field(min_length=1, max_length=200)]


class Model(BaseModel):
    model_config = ConfigDict(from_attributes=True, extra="forbid")


class Page(BaseModel, Generic[T]):
    """A list of things."""

    items: list[T]


class OptionOut(Model):
    name: str
    label: str
    default: float
    low: float
    high: float
    step: float
    help: str


class ControlOut(Model):
    field: str
    label: str
    negative: Sequence[str]
    positive: Sequence[str]


class FieldOut(BaseModel):
    name: str
    unit: str
    low: float | None
    """None where there is no bound."""
    high: float | None


class PerceptionOut(BaseModel):
    name: str
    summary: str
    state: list[FieldOut]


class SignalOut(BaseModel):
    name: str
    label: str
    key: str
    placed: bool
    """Whether it is meant at a place on the ground."""


class EventOut(BaseModel):
    name: str
    label: str
    """What a person reads where it is so."""


class SceneOut(BaseModel):
    name: str
    title: str
    version: int
    dt_s: float
    outcomes: list[str]
    successes: list[str]
    options: list[OptionOut]
    controls: list[ControlOut]
    signals: list[SignalOut]
    events: list[EventOut]
    """What a switch between policies can hang on."""
    action: list[FieldOut]
    """In the world's frame; empty where that is one of a set of symbols."""
    symbols: list[str]
    """What it chooses among under its first perception; empty where it chooses numbers."""
    perceptions: list[PerceptionOut]
    many: bool
    """Whether many characters share a world, of which a person guides one."""
    people: bool
    """Whether it shows people, who move as the chosen clips say."""


class ClipFileOut(Model):
    name: str
    clips: list[str]
    problem: str | None
    """Why it cannot be used, or None."""


class ActivityOut(Model):
    name: str
    label: str
    file: str | None
    """None where people move as shipped."""
    clip: str | None
    problem: str | None
    """Why what was chosen cannot be played, or None."""


class ClipsOut(Model):
    folder: str
    """Where files of clips lie."""
    files: list[ClipFileOut]
    activities: list[ActivityOut]
    problem: str | None
    """Why the choices cannot be read, or None."""


class ClipIn(Model):
    file: Name
    clip: Name


class SessionIn(Model):
    scene: Name
    name: Name
    demonstrator: Name = "person"


class CleaningOut(Model):
    pairs: int
    removed: int
    stale: bool
    created_at: float
    settings: Mapping[str, Any]


class SessionOut(Model):
    id: int
    name: str
    scene: str
    scene_version: int
    demonstrator: str
    created_at: float
    made_by: str
    takes_kept: int
    takes_trashed: int
    pairs: int
    seconds: float
    cleaning: CleaningOut | None


class TakeOut(Model):
    id: int
    session: int
    number: int
    scene_version: int
    seed: int
    options: Mapping[str, float]
    pilot: str
    pairs: int
    seconds: float
    outcome: str | None
    started_at: float
    trashed: bool


class CleanIn(Model):
    perception: Name | None = None
    n_neighbors: Annotated[int, Field(ge=1, le=1000)] | None = None
    threshold: Annotated[float, Field(gt=0.0, le=10.0)] | Literal["auto"] | None = None
    delay: Delay = "auto"


class TuneIn(Model):
    learner: Name | None = None
    perception: Name | None = None


class DiagnoseIn(Model):
    perception: Name | None = None
    delay: Delay = "auto"


class FitIn(Model):
    learner: Name | None = None
    perception: Name | None = None
    settings: dict[str, Any] = {}
    delay: Delay = "auto"
    name: Annotated[str, Field(max_length=80)] | None = None


class EvaluateIn(Model):
    scene: Name
    policies: Annotated[list[Name], Field(min_length=1, max_length=20)]
    """Policies, scripted demonstrators or other pilots, by name."""
    options: dict[str, float] = {}
    worlds: Annotated[int, Field(ge=1, le=100_000)] = 100
    seed: Annotated[int, Field(ge=0, lt=2**53)] = 0
    like: Name | None = None
    """The one of them that the others should move like."""


class EvaluationOut(Model):
    id: int
    scene: str
    created_at: float
    asked: Mapping[str, Any]
    """What makes it again."""
    versions: Mapping[str, str]
    result: Mapping[str, Any]


class EntryIn(Model):
    policy: Name
    when: Annotated[str, Field(min_length=1, max_length=400)] | None = None
    """Text of the condition; none for the last."""


class SwitchIn(Model):
    name: Annotated[str, Field(max_length=80)]
    entries: Annotated[list[EntryIn], Field(min_length=2, max_length=16)]
    perception: Name | None = None
    """What a learned condition may look at beside the signs of the scene."""


class JobOut(Model):
    id: int
    kind: str
    session: int | None
    state: str
    progress: float
    message: str
    result: Mapping[str, Any] | None
    error: str | None


class PolicyOut(BaseModel):
    name: str
    scene: str | None
    scene_version: int | None
    perception: str | None
    learner: str | None
    settings: dict[str, Any]
    pairs: int | None
    session: str | None
    """Name of the session it was fitted to."""
    report: list[str]
    """What fitting or tuning said of it, or when a switch switches, for people."""
    switches: list[str]
    """The policies of a switch, the first choice first; empty for a policy."""
    made_by: str | None
    created: str | None
    shipped: bool
    stale: bool
    """The session's pairs have changed since it was fitted."""
    problem: str | None
    """Why it cannot play, or None."""


class StageIn(Model):
    scene: Name
    options: dict[str, float] = {}
    session: int | None = None
    seed: Annotated[int, Field(ge=0, lt=2**53)] | None = None


class StageOut(BaseModel):
    id: str
    scene: str
    view: str
    """Path of the 3D view."""
    socket: str
    """Path of the websocket that takes keys and commands and tells the status."""


FromMiddle = Annotated[float, Field(ge=-1, le=1)]


class CommandIn(Model):
    """What a person does on a stage."""

    name: Literal[
        "demonstrate",
        "pause",
        "resume",
        "restart",
        "discard",
        "undo",
        "play",
        "stop",
        "session",
        "signal",
        "camera",
        "another",
    ]
    policy: Name | None = None
    others: Name | None = None
    """Whose policy everybody else follows in a demonstration; they stand still without one."""
    camera: Name | None = None
    """Of the scene's cameras, the one to see it from; the next one where none is named."""
    options: dict[str, float] | None = None
    session: int | None = None
    signal: Name | None = None
    """Of the scene's signals, the one to give."""
    pointer: tuple[FromMiddle, FromMiddle, Annotated[float, Field(gt=0, le=100)]] | None = None
    """Where in the view it is meant: across and up, from -1 to 1, and its width over its height."""


class KeysIn(Model):
    """Exactly these keys are held."""

    held: Annotated[list[Annotated[str, Field(max_length=40)]], Field(max_length=40)]
    time_ms: FiniteFloat
    """When, on the browser's clock, milliseconds since the epoch."""
    seq: int = 0
