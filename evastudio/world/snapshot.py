"""Snapshots: everything about a batch of worlds at one moment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError

AnyArray = NDArray[Any]
"""Of any dtype: snapshots hold counters and flags beside real numbers."""


class Rows(Mapping[str, AnyArray]):
    """The arrays of `whole` at `rows`, copied only where they are asked for.

    What is fixed in many worlds is large, and worlds leave a batch one by one.
    """

    def __init__(self, whole: Mapping[str, AnyArray], rows: NDArray[np.int64]) -> None:
        self.whole = whole
        self.rows = rows
        self._copied: dict[str, AnyArray] = {}

    def __getitem__(self, name: str) -> AnyArray:
        if name not in self._copied:
            self._copied[name] = self.whole[name][self.rows]
        return self._copied[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.whole)

    def __len__(self) -> int:
        return len(self.whole)

    def __reduce__(self) -> tuple[Any, ...]:
        """To another process go these rows alone."""
        return dict, (dict(self),)


@dataclass(frozen=True)
class Snapshot:
    """A batch of worlds at one moment. Every array has `worlds` as its leading axis."""

    fixed: Mapping[str, AnyArray]
    """What does not change between reset and the end of a take; stored once a take."""
    moving: Mapping[str, AnyArray]
    """What a step may change; stored once a decision step."""

    def __post_init__(self) -> None:
        if not self.moving or not self.fixed.keys().isdisjoint(self.moving):
            raise InvalidInputError(
                "A snapshot needs at least one moving array, and no name both fixed and moving."
            )
        counts = {name: len(array) for name, array in self.moving.items()}
        if isinstance(self.fixed, Rows):
            counts["what is fixed"] = len(self.fixed.rows)
        else:
            counts.update((name, len(array)) for name, array in self.fixed.items())
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
        moving = {name: array[index] for name, array in self.moving.items()}
        if isinstance(index, slice) and not isinstance(self.fixed, Rows):
            return Snapshot({name: array[index] for name, array in self.fixed.items()}, moving)
        fixed, own = self.shared()
        return Snapshot(Rows(fixed, own[index]), moving)

    def shared(self) -> tuple[Mapping[str, AnyArray], NDArray[np.int64]]:
        """What is fixed without a copy of it: arrays, and which of their rows each world has.

        A row can be that of several worlds: of all the moments of a take, say.
        """
        if isinstance(self.fixed, Rows):
            return self.fixed.whole, self.fixed.rows
        if self.fixed and all(array.strides[0] == 0 for array in self.fixed.values()):
            one = {name: array[:1] for name, array in self.fixed.items()}
            return one, np.zeros(self.worlds, dtype=np.int64)
        return self.fixed, np.arange(self.worlds)


def moments_of(fixed: Mapping[str, AnyArray], moving: Mapping[str, AnyArray]) -> Snapshot:
    """Moments of one world as a batch: `moving` has them as leading axis, of any length.

    `fixed`, of one world (1, ...), is not copied.
    """
    count = len(next(iter(moving.values())))
    held = {name: np.broadcast_to(one, (count, *one.shape[1:])) for name, one in fixed.items()}
    return Snapshot(held, moving)


def stack(snapshots: Sequence[Snapshot]) -> Snapshot:
    """One batch from several, in order. All must hold arrays of the same names and shapes."""
    first = snapshots[0]
    return Snapshot(
        {name: np.concatenate([s.fixed[name] for s in snapshots]) for name in first.fixed},
        {name: np.concatenate([s.moving[name] for s in snapshots]) for name in first.moving},
    )
