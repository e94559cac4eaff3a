"""How many decisions fell and how late they began, of one stage or of many."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field

BOUNDS_S = (0.001, 0.002, 0.005, 0.01, 0.02, 1 / 30, 0.05, 0.1, 0.2, 0.5, 1.0)
"""Decisions are counted by how late they began at most; the last count is of those still later."""


@dataclass
class Tally:
    """Counts that only grow."""

    steps: int = 0
    late_steps: int = 0
    seconds: float = 0.0
    """By which decisions began late, added up."""
    by_lateness: list[int] = field(default_factory=lambda: [0] * (len(BOUNDS_S) + 1))

    def note(self, drift_s: float) -> None:
        """Count a decision that began `drift_s` seconds after its time."""
        self.steps += 1
        self.seconds += drift_s
        self.by_lateness[bisect_left(BOUNDS_S, drift_s)] += 1


def total(tallies: Sequence[Tally]) -> Tally:
    """What they count together."""
    whole = Tally()
    for one in tallies:
        whole.steps += one.steps
        whole.late_steps += one.late_steps
        whole.seconds += one.seconds
        pairs = zip(whole.by_lateness, one.by_lateness, strict=True)
        whole.by_lateness = [mine + theirs for mine, theirs in pairs]
    return whole
