"""Snapshots: everything about a batch of worlds at one moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError

AnyArray = NDArray[Any]
"""Of any dtype: snapshots hold counters and flags beside real numbers."""


@dataclass(frozen=True)
class Snapshot:
    """A batch of worlds at one moment. Every array has `worlds` as its leading axis."""

    fixed: Mapping[str, AnyArray]
    """What does not change between reset and the end of a take; stored once a take."""
    moving: Mapping[str, AnyArray]
    """What a step may change; stored once a decision step."""

    def __post_init__(self) -> None:
        arrays = {**self.fixed, **self.moving}
        if not self.moving or len(arrays) != len(self.fixed) + len(self.moving):
            raise InvalidInputError(
                "A snapshot needs at least one moving array, and no name both fixed and moving."
            )
        counts = {name: len(array) for name, array in arrays.items()}
        if len(set(counts.values())) != 1:
            raise InvalidInputError(f"The arrays of a snapshot differ in worlds: {counts}.")

    def __getitem__(self, name: str) -> AnyArray:
        found = self.moving.get(name)
        return self.fixed[name] if found is None else found

    @property
    def worlds(self) -> int:
        """Number of worlds in the batch."""
        return len(next(iter(self.moving.values())))

    def after(self, **moving: AnyArray) -> Snapshot:
        """The same worlds later: `moving` replaces arrays of that name."""
        return Snapshot(self.fixed, {**self.moving, **moving})

    def take(self, index: AnyArray | slice) -> Snapshot:
        """The worlds at `index` (a slice, a mask or integers)."""
        return Snapshot(
            {name: array[index] for name, array in self.fixed.items()},
            {name: array[index] for name, array in self.moving.items()},
        )


def stack(snapshots: Sequence[Snapshot]) -> Snapshot:
    """One batch from several, in order. All must hold arrays of the same names and shapes."""
    first = snapshots[0]
    return Snapshot(
        {name: np.concatenate([s.fixed[name] for s in snapshots]) for name in first.fixed},
        {name: np.concatenate([s.moving[name] for s in snapshots]) for name in first.moving},
    )
