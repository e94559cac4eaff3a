"""Live stages over HTTP, field by field."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from evastudio.api.models.common import Given, Name, Options, Seed


class StageIn(Given):
    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"scene": "asteroids", "options": {"density": 0.5}, "seed": 7}]
        }
    )

    scene: Name
    options: Options
    session: int | None = None
    seed: Seed | None = None


class StageOut(BaseModel):
    id: str
    scene: str
    view: str
    """Path of the 3D view."""
    socket: str
    """Path of the websocket that takes keys and commands and tells the status."""


FromMiddle = Annotated[float, Field(ge=-1, le=1, allow_inf_nan=False)]


class PushIn(Given):
    """Keys held for a little while, to come where nobody was."""

    keys: Annotated[list[Annotated[str, Field(max_length=40)]], Field(max_length=40)]
    steps: Annotated[int, Field(ge=1, le=1000)]


class CommandIn(Given):
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
        "fork",
        "take-over",
        "hand-back",
        "keep-last",
        "review",
        "compare",
        "leave",
        "seek",
        "roll",
        "pace",
        "forget",
        "visit",
        "feel",
        "series",
    ]
    policy: Name | None = None
    others: Name | None = None
    """Whose policy everybody else follows in a demonstration; they stand still without one."""
    camera: Name | None = None
    """Of the scene's cameras, the one to see it from; the next one where none is named."""
    options: Annotated[dict[Name, FiniteFloat], Field(max_length=100)] | None = None
    session: int | None = None
    take: int | None = None
    """The take to look back at, where none is named the run on the stage; or the one to keep the
    end of, where none is named the last."""
    step: Annotated[int, Field(ge=0)] = 0
    """The moment of the take that is to be left out, compared with moments like it, or pushed on
    from."""
    push: PushIn | None = None
    """What is held from there on before the person goes on."""
    pushes: bool = False
    """Whether a demonstration is to be pushed off its way now and then."""
    seconds: Annotated[float, Field(ge=0, le=86_400)] = 0.0
    """Where to look back at, since the run began, how much of a take's end to keep, how long to
    rest between takes, or from where on to play: the policy is brought there and held still."""
    seed: Seed | None = None
    """Of the world to play in; a new one where none is given."""
    speed: FiniteFloat = 1.0
    """Of a look back, or the pace of time."""
    sensitivity: FiniteFloat = 1.0
    """How far held keys and sticks go, in shares of their own reach."""
    ramp: FiniteFloat = 1.0
    """How long held keys take to get there, in shares of their own ramp."""
    wanted: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """How many takes the session is to have."""
    automatic: bool = False
    """Whether the next take begins by itself, after a rest of `seconds`."""
    same: bool = False
    """Whether to begin again in the same world."""
    signal: Name | None = None
    """Of the scene's signals, the one to give."""
    pointer: (
        Annotated[
            tuple[FromMiddle, FromMiddle, Annotated[float, Field(gt=0, le=100)]],
            Field(strict=False),
        ]
        | None
    ) = None
    """Where in the view it is meant: across and up, from -1 to 1, and its width over its height."""


class KeysIn(Given):
    """Exactly these keys are held, and sticks pushed so far."""

    held: Annotated[list[Annotated[str, Field(max_length=40)]], Field(max_length=40)]
    pushed: Annotated[
        dict[Annotated[str, Field(max_length=40)], FromMiddle],
        Field(default_factory=dict, max_length=40),
    ]
    """How far each control is pushed by a stick, by its field."""
    time_ms: FiniteFloat
    """When, on the browser's clock, milliseconds since the epoch."""
    seq: int = 0
    for_ms: Annotated[float, Field(gt=0, le=60_000)] | None = None
    """They count as released after this long unless told again, for a connection may hang without
    a word; None: held until something else is told."""
