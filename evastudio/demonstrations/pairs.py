"""Pairs: the states a demonstrator saw and the actions that answered them, under one perception."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.cast import of_lead
from evastudio.world.scene import Percept, Perception
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

TAKE_APART = 1 << 40
"""Steps between the moments of one take and those of the next; no take is as long."""


@dataclass(frozen=True)
class Pairs:
    """State-action pairs of several takes, in the character's own frame."""

    states: Array
    """Shape (pairs, state size)."""
    actions: Array
    """Shape (pairs, action size)."""
    takes: NDArray[np.int64]
    """The take each pair came from, shape (pairs,)."""
    steps: NDArray[np.int64]
    """Its decision step within that take, shape (pairs,)."""

    def __post_init__(self) -> None:
        counts = {len(self.states), len(self.actions), len(self.takes), len(self.steps)}
        if len(counts) != 1:
            raise InvalidInputError(f"States, actions, takes and steps differ in length: {counts}.")

    def __len__(self) -> int:
        return len(self.states)

    @property
    def moments(self) -> NDArray[np.int64]:
        """When each was, (pairs,): 1 apart from one step of a take to the next, takes far apart."""
        ranks = np.unique(self.takes, return_inverse=True)[1]
        return np.asarray(ranks.astype(np.int64) * TAKE_APART + self.steps)

    def keep(self, mask: NDArray[np.bool_]) -> Pairs:
        """The pairs where `mask` (pairs,) is true."""
        return Pairs(self.states[mask], self.actions[mask], self.takes[mask], self.steps[mask])


@dataclass(frozen=True)
class SeenTake:
    """One take as a perception shows it, before it is said which state an action answered."""

    perception: Perception
    percept: Percept
    """What was perceived at each step."""
    moments: Snapshot
    """The moving part of its snapshots."""
    actions: Array
    """What was done then, in the world's frame, leading axis steps; of all where many act."""
    take: int
    applies: NDArray[np.bool_]
    """Which of its moments the perception is about, shape (steps,)."""

    def __len__(self) -> int:
        return len(self.actions)

    def pairs(self, delay_steps: int = 0) -> Pairs:
        """Each action with the state `delay_steps` before it, in the frame of that moment.

        A pair's step is that of its action; the first `delay_steps` actions answer nothing that
        was recorded and are left out, and so is what the perception is not about.
        """
        steps = self._answers(delay_steps)
        seen = steps - delay_steps
        then = self.moments.take(seen)
        own = self.perception.to_own(self.percept.frame[seen], self.actions[steps])
        return Pairs(
            of_lead(then, self.percept.states[seen]),
            of_lead(then, own),
            np.full(len(steps), self.take, dtype=np.int64),
            steps,
        )

    def frames(self, delay_steps: int = 0) -> AnyArray:
        """The frames that the actions of `pairs(delay_steps)` are given in."""
        seen = self._answers(delay_steps) - delay_steps
        return of_lead(self.moments.take(seen), self.percept.frame[seen])

    def _answers(self, delay_steps: int) -> NDArray[np.int64]:
        """The steps whose actions answer something that was recorded and is meant."""
        steps = np.arange(min(delay_steps, len(self)), len(self), dtype=np.int64)
        return steps[self.applies[steps] & self.applies[steps - delay_steps]]


def see_take(perception: Perception, snapshots: Snapshot, actions: Array, take: int) -> SeenTake:
    """One take through `perception`: `snapshots` holds its moments along the worlds axis."""
    moments = Snapshot({}, snapshots.moving)
    percept, applies = perception.perceive(snapshots), perception.applies(snapshots)
    return SeenTake(perception, percept, moments, actions, take, applies)


def perceive_take(
    perception: Perception, snapshots: Snapshot, actions: Array, take: int, delay_steps: int = 0
) -> Pairs:
    """The pairs of one take; see `SeenTake.pairs`."""
    return see_take(perception, snapshots, actions, take).pairs(delay_steps)


def answered_pairs(pairs: Pairs, delay_steps: int) -> Pairs:
    """Each action of finished `pairs` with the state `delay_steps` before it in its take.

    For data without snapshots, whose actions are in one frame all along. The rows of a take must
    be in order; actions whose state is not among the pairs are left out.
    """
    late = np.arange(min(delay_steps, len(pairs)), len(pairs))
    seen = late - delay_steps
    same = pairs.takes[late] == pairs.takes[seen]
    same &= pairs.steps[late] - pairs.steps[seen] == delay_steps
    late, seen = late[same], seen[same]
    return Pairs(pairs.states[seen], pairs.actions[late], pairs.takes[late], pairs.steps[late])


def join_pairs(parts: Sequence[Pairs]) -> Pairs:
    """The pairs of several takes, in order. Raises InvalidInputError where there are none."""
    if not parts:
        raise InvalidInputError("There are no pairs: no take is kept. Record a take first.")
    return Pairs(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.actions for part in parts]),
        np.concatenate([part.takes for part in parts]),
        np.concatenate([part.steps for part in parts]),
    )
