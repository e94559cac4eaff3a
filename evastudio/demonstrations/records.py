"""What the session store holds, as frozen records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

RECORDED = -1
"""In place of a seed: the world was recorded elsewhere, and begins as its first snapshot says."""


@dataclass(frozen=True)
class CleaningRecord:
    """The cleaning in force for a session."""

    id: int
    created_at: float
    settings: Mapping[str, Any]
    pairs: int
    """Pairs that were looked at."""
    removed: int
    """Pairs marked as conflicts."""
    stale: bool
    """Takes were added, trashed or restored since."""


@dataclass(frozen=True)
class SessionRecord:
    """The takes one demonstrator made of one scene for one purpose."""

    id: int
    name: str
    scene: str
    scene_version: int
    demonstrator: str
    created_at: float
    """Seconds since the epoch."""
    made_by: str
    """The command that records it again; empty where a person demonstrated."""
    takes_kept: int
    takes_trashed: int
    pairs: int
    """Pairs of the kept takes."""
    seconds: float
    """Duration of the kept takes."""
    cleaning: CleaningRecord | None


@dataclass(frozen=True)
class NewTake:
    """A take as it begins."""

    key: str | None
    """What its writer calls it: of two with one key the first is made."""
    session: int
    scene_version: int
    seed: int
    options: Mapping[str, float]
    dt_s: float
    pilot: str
    perception: str
    started_at: float
    """Seconds since the epoch."""
    origin: Origin | None
    """What it goes on from, where that is no new world."""
    fixed: bytes
    """The unchanging arrays of its world, packed."""


@dataclass(frozen=True)
class TakeRecord:
    """One unbroken demonstration in one world."""

    id: int
    session: int
    number: int
    """Its place in the session, from 1."""
    scene_version: int
    seed: int
    """Of its world, or RECORDED."""
    options: Mapping[str, float]
    """Options of the scene in which it was made."""
    pilot: str
    pairs: int
    seconds: float
    outcome: str | None
    """None while it is being recorded, and where recording was cut off."""
    started_at: float
    trashed: bool
    origin: Origin | None
    """None where it began in a world of its own."""
    note: str
    """What a person wrote about it."""


@dataclass(frozen=True)
class Origin:
    """What a take goes on from, where that is no new world: a moment of some run."""

    step: int
    """The decision of that run before which it goes on."""
    take: int | None = None
    """The take that it forks from; None where the run was not recorded."""
    policy: str | None = None
    """The policy that a person took over from: the take corrects it."""
    seed: int | None = None
    """Of the world it was in."""

    def later(self, steps: int) -> Origin:
        """That many decisions on."""
        return replace(self, step=self.step + steps)


@dataclass(frozen=True)
class TakeData:
    """The content of a take."""

    snapshots: Snapshot
    """Its moments in order, along the worlds axis."""
    states: Array
    """What the recorder saw, under the scene's default perception; shape (pairs, state size)."""
    actions: Array
    """In the world's frame, shape (pairs, action size)."""


Marks = Mapping[int, NDArray[np.bool_]]
"""For each take that a cleaning looked at: which of its pairs are conflicts."""


class Verdict(StrEnum):
    """What a person says of a pair that conflicts with others."""

    KEEP = "keep"
    """It was meant: no cleaning leaves it out."""
    DELETE = "delete"
    """It was a mistake: every cleaning leaves it out."""
    MISSING = "missing"
    """It was meant, and so were the others: the perception does not show what tells them apart
    (paper 4.2). No cleaning leaves it out."""


Verdicts = Mapping[tuple[int, int], Verdict]
"""By take and step."""
