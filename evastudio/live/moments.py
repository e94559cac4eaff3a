"""The moments of one run, in blocks: as objects of their own they would take ten times the memory
of a small world, and all stages would wait while garbage is looked for among them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np

from evastudio.world.snapshot import AnyArray, Snapshot

BLOCK = 256
"""At most so many moments are kept, and forgotten, together."""
BLOCK_BYTES = 2**20
"""And at most so much, unless one moment is larger."""
FIRST = 16
"""Moments in the first block; each has room for twice as many as are in the one before."""


@dataclass
class _Block:
    first: int
    """Which moment is its first."""
    room: int
    arrays: Mapping[str, AnyArray]
    """What moves, leading axis `room`. What is written there is never written again."""

    def fits(self, moment: Snapshot) -> bool:
        """Whether `moment` is of the arrays that it keeps."""
        return all(
            kept.dtype == moment.moving[name].dtype
            and kept.shape[1:] == moment.moving[name].shape[1:]
            for name, kept in self.arrays.items()
        )


class Moments(Sequence[Snapshot]):
    """Snapshots of one world, of which what is fixed is the same in all."""

    def __init__(self) -> None:
        self.first = 0
        """How many were forgotten."""
        self.bytes = 0
        """What moves in those that are kept."""
        self._end = 0
        self._fixed: Mapping[str, AnyArray] = {}
        self._blocks: list[_Block] = []

    def append(self, moment: Snapshot) -> None:
        """What comes next."""
        size = sum(array.nbytes for array in moment.moving.values())
        if not self._blocks:
            self._fixed = moment.fixed
        block = self._blocks[-1] if self._blocks else None
        if block is None or self._end - block.first == block.room or not block.fits(moment):
            block = self._new_block(moment, size)
        for name, kept in block.arrays.items():
            kept[self._end - block.first] = moment.moving[name][0]
        self._end += 1
        self.bytes += size

    def _new_block(self, moment: Snapshot, size: int) -> _Block:
        before = self._end - self._blocks[-1].first if self._blocks else FIRST // 2
        room = max(min(2 * before, BLOCK, BLOCK_BYTES // max(size, 1)), 1)
        arrays = {
            name: np.empty((room, *array.shape[1:]), array.dtype)
            for name, array in moment.moving.items()
        }
        self._blocks.append(_Block(self._end, room, arrays))
        return self._blocks[-1]

    def forget(self) -> range:
        """Those of the oldest block, unless it is the only one; which they were."""
        if len(self._blocks) < 2:
            return range(0)
        oldest, following = self._blocks[0], self._blocks[1]
        gone = range(oldest.first, following.first)
        self.bytes -= len(gone) * sum(one[:1].nbytes for one in oldest.arrays.values())
        self.first = following.first
        del self._blocks[0]
        return gone

    def as_they_are(self) -> Moments:
        """The same, to which nothing is added; for any thread."""
        same = Moments()
        same.first, same.bytes, same._end = self.first, self.bytes, self._end
        same._fixed, same._blocks = self._fixed, list(self._blocks)
        return same

    def __len__(self) -> int:
        return self._end - self.first

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Snapshot]: ...
    def __getitem__(self, index: int | slice) -> Snapshot | Sequence[Snapshot]:
        """The moment at `index` of those that are kept; the first of them is 0."""
        if isinstance(index, slice):
            return [self[one] for one in range(*index.indices(len(self)))]
        at = range(self.first, self._end)[index]
        block = self._blocks[bisect_right(self._blocks, at, key=lambda one: one.first) - 1]
        row = slice(at - block.first, at - block.first + 1)
        return Snapshot(self._fixed, {name: kept[row] for name, kept in block.arrays.items()})
