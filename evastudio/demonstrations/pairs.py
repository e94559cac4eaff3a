"""Pairs: the states a demonstrator saw and the actions that answered them, under one perception."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.cast import of_lead
from evastudio.world.scene import Perception
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


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

    def keep(self, mask: NDArray[np.bool_]) -> Pairs:
        """The pairs where `mask` (pairs,) is true."""
        return Pairs(self.states[mask], self.actions[mask], self.takes[mask], self.steps[mask])


def perceive_take(perception: Perception, snapshots: Snapshot, actions: Array, take: int) -> Pairs:
    """The pairs of one take: `snapshots` holds its moments along the worlds axis."""
    percept = perception.perceive(snapshots)
    return Pairs(
        of_lead(snapshots, percept.states),
        of_lead(snapshots, perception.to_own(percept.frame, actions)),
        np.full(len(actions), take, dtype=np.int64),
        np.arange(len(actions), dtype=np.int64),
    )


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
