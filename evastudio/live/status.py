"""How a stage stands: what a person needs to know of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class Advice(StrEnum):
    """What the coach makes of how a person steers."""

    SEEN = "seen"
    """What they decide can be told from what the character perceives, and so be learned."""
    NOTHING = "nothing"
    """They have hardly steered."""
    FAINT = "faint"
    """They steer so early and so little that it does not show."""
    HIDDEN = "hidden"
    """What they decide cannot be told from what the character perceives."""


class Phase(StrEnum):
    READY = "ready"
    COUNTDOWN = "countdown"
    RECORDING = "recording"
    PAUSED = "paused"
    PLAYING = "playing"
    ENDED = "ended"
    REVIEWING = "reviewing"


class Mode(StrEnum):
    DEMONSTRATE = "demonstrate"
    PLAY = "play"
    CORRECT = "correct"
    """A person has taken over from what plays."""
    REVIEW = "review"
    """Looking back at a run or a take."""


@dataclass(frozen=True)
class Status:
    """What a person needs to know of a stage."""

    phase: Phase
    mode: Mode | None
    countdown_s: float
    pairs: int
    """Pairs of the running or the last take."""
    seconds: float
    """Time in this world."""
    progress: float
    outcome: str | None
    success: bool | None
    can_undo: bool
    late_steps: int
    steps: int
    pace: float
    """Seconds of the world's time in one of real time."""
    position_s: float | None
    """Where in the run one looks back at, and None where one does not."""
    length_s: float
    """How much of the present run, or the one looked back at, is remembered."""
    speed: float
    """How fast the look back goes on; 0 where it stands."""
    take: int | None
    """The take that is looked back at, where it is one."""
    drift_s: float
    """How far the latest step began after its time."""
    policy: str | None
    """Who plays: the name of a policy, or of another pilot."""
    others: str | None
    """Who acts for the others while a person leads one of many; None where they stand still."""
    familiarity: float | None
    """How much the moment of the latest decision is like what was demonstrated, 0 to 1; None where
    no policy decides, or it does not know."""
    silent: str | None
    """Why what plays cannot tell what its latest decision came from; None where it can, and where
    nothing plays."""
    forgotten: int
    """Demonstrated moments that were left out on this stage while something played."""
    by_hand: bool
    """Whether the moment that is looked at was steered by a person who had taken over."""
    pushed: bool
    """Whether the character is forced off its way just now, which nobody records."""
    pushes: bool
    """Whether that is done now and then."""
    decision: str | None
    """The symbol that the next decision would be as of now, or, where a pilot plays, that it chose
    last; None where decisions are not symbols, or nothing moves."""
    decides_s: float | None
    """Seconds until the next decision falls; None where `decision` is not told."""
    lead: int | None
    """Which of many characters a person guides and the camera follows."""
    camera: str
    cameras: tuple[str, ...]
    """Where it can be seen from."""
    seed: int
    forked: bool
    """Whether the run goes on from a moment of another, and can begin there once more."""
    options: Mapping[str, float]
    coach: Advice | None
    """What the coach makes of how one steers; None where it is too early to say."""
    problem: str | None
    """Why saving does not work at the moment, or None."""
