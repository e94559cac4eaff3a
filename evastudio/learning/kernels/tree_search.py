"""The compiled way to search: a tree of boxes, and leaves of what came after it was built."""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from evastudio.learning.kernels.decide import decide_many, decide_row, decide_rows, scratch
from evastudio.learning.kernels.lanes import LEAF
from evastudio.learning.kernels.search import search_many, search_rows
from evastudio.learning.kernels.tree import FAR, NONE, Floats, build_tree
from evastudio.learning.neighbors import LARGEST, Averaging, Others
from evastudio.learning.plain_search import PlainSearch
from evastudio.world.spaces import Array

MANY = 1000
"""Queries from which on it pays to wake the other processors."""
ADDED = 512
"""Points that may wait outside the tree, or a sixty-fourth of those in it."""


class _Scratch(threading.local):
    """What one decision needs for its search, kept by each thread for the next."""

    def __init__(self) -> None:
        self.by_k: dict[int, tuple[Floats, NDArray[np.int64]]] = {}


class TreeSearch:
    """See `neighbors.Search`."""

    def __init__(self, points: Floats) -> None:
        self._points = points
        self._numbers = np.arange(len(points))
        self._scratch = _Scratch()
        self._rebuild()

    def __getstate__(self) -> dict[str, object]:
        """Scratch memory belongs to threads and stays behind."""
        return {name: value for name, value in self.__dict__.items() if name != "_scratch"}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state, _scratch=_Scratch())

    def nearest(self, queries: Floats, k: int) -> tuple[Floats, NDArray[np.int64]]:
        """As `neighbors.Search` says."""
        return self._nearest(queries, k, np.empty(0, np.int32))

    def nearest_others(self, k: int, others: Others) -> NDArray[np.int64]:
        """As `neighbors.Search` says."""
        if others.moments is None:
            return self._nearest(self._points, k, self._numbers.astype(np.int32))[1]
        return self._plain().nearest_others(k, others)

    def median_deviations(self, actions: Array, k: int, others: Others) -> Array:
        """As `neighbors.Search` says."""
        return self._plain().median_deviations(actions, k, others)

    def _plain(self) -> PlainSearch:
        plain = PlainSearch(self._points)
        plain._numbers = self._numbers
        return plain

    def _nearest(
        self, queries: Floats, k: int, skips: NDArray[np.int32]
    ) -> tuple[Floats, NDArray[np.int64]]:
        rows = len(queries)
        squares = np.empty((rows, k), np.float32)
        numbers = np.empty((rows, k), np.int64)
        flat = queries.reshape(-1)
        if rows < MANY:
            search_rows(flat, 0, rows, skips, *self._arrays, k, squares, numbers)
        else:
            search_many(flat, rows, skips, *self._arrays, k, squares, numbers)
        return squares, numbers

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """As `neighbors.Search` says."""
        rows = len(states)
        k, inverse = rule.k, rule.inverse
        _, *tree = self._arrays
        out = np.empty((rows, actions.shape[1]))
        if rows == 1:
            kept = self._scratch.by_k.get(k)
            if kept is None:
                kept = self._scratch.by_k[k] = scratch(self._size, k)
            decide_row(
                states, 0, rule.offset, rule.scale, LARGEST, *tree, actions, k, inverse, *kept, out
            )
        elif rows < MANY:
            decide_rows(
                states, 0, rows, rule.offset, rule.scale, LARGEST, *tree, actions, k, inverse, out
            )
        else:
            decide_many(states, rule.offset, rule.scale, LARGEST, *tree, actions, k, inverse, out)
        return out

    def add(self, points: Floats, first: int) -> None:
        """As `neighbors.Search` says."""
        count = len(points)
        self._points = np.concatenate([self._points, points])
        self._numbers = np.concatenate([self._numbers, np.arange(first, first + count)])
        self._waiting += count
        if self._waiting > max(ADDED, len(self._points) // 64):
            self._rebuild()
        else:
            self._pack_added()

    def remove(self, numbers: NDArray[np.int64]) -> None:
        """As `neighbors.Search` says."""
        kept = ~np.isin(self._numbers, numbers)
        self._waiting -= int((~kept[len(kept) - self._waiting :]).sum())
        self._points, self._numbers = self._points[kept], self._numbers[kept]
        tree_numbers = self._arrays[4]
        tree_numbers[np.isin(tree_numbers, numbers)] = NONE
        self._gone += int((~kept).sum())
        if self._gone * 2 > len(self._points):
            self._rebuild()
        else:
            self._pack_added()

    def _rebuild(self) -> None:
        tree = build_tree(self._points)
        held = tree.numbers != NONE
        tree.numbers[held] = self._numbers[tree.numbers[held]]
        self._size = tree.size
        self._waiting = self._gone = 0
        self._arrays = (
            tree.size, tree.nodes, tree.children, tree.leaves, tree.numbers,
            np.empty(0, np.float32), np.empty(0, np.int32),
        )  # fmt: skip

    def _pack_added(self) -> None:
        """Lay the waiting points out in leaves, as the tree's are."""
        leaves = -(-self._waiting // LEAF)
        points = np.full((leaves * LEAF, self._size), FAR, np.float32)
        numbers = np.full(leaves * LEAF, NONE, np.int32)
        first = len(self._points) - self._waiting
        points[: self._waiting] = self._points[first:]
        numbers[: self._waiting] = self._numbers[first:]
        packed = points.reshape(leaves, LEAF, self._size).transpose(0, 2, 1)
        self._arrays = (*self._arrays[:5], np.ascontiguousarray(packed).reshape(-1), numbers)
