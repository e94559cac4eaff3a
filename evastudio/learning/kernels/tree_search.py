"""The compiled way to search: a tree of boxes, and leaves of what came after it was built."""

from __future__ import annotations

from typing import Any

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.learning.kernels.decide import decide, decide_rows
from evastudio.learning.kernels.sharing import share
from evastudio.learning.kernels.tree import (
    FAR,
    NONE,
    OFFSET,
    TABLE,
    Floats,
    Tree,
    build_tree,
    pack_leaves,
)
from evastudio.learning.neighbors import Averaging, Indices, Others
from evastudio.world.spaces import Array

MANY = 1000
"""Queries from which on it pays to wake the other processors."""
EACH = 256
"""Queries that a processor takes at a time."""
LEAVES_EACH = 64
WAITING = 512
"""Points that may wait outside the tree, or a sixty-fourth of those in it."""


class TreeSearch:
    """See `neighbors.Search`."""

    def __init__(self, points: Floats) -> None:
        self._points = points
        self._numbers = np.arange(len(points))
        self._waiting = 0
        self._places: Indices | None = None
        self._rebuild()

    def __getstate__(self) -> dict[str, object]:
        """All but the table, whose addresses mean nothing elsewhere."""
        return {**self.__dict__, "_table": None, "_asked": None}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._lay_out()

    def nearest(self, queries: Floats, k: int) -> tuple[Floats, Indices]:
        """As `neighbors.Search` says."""
        from evastudio.learning.kernels.batches import search_rows  # decisions go without

        rows = len(queries)
        squares, numbers = np.empty((rows, k), np.int32), np.empty((rows, k), np.int64)

        def work(first: int, last: int) -> None:
            search_rows(self._address, queries, first, last, k, squares, numbers)

        share(rows, EACH if rows >= MANY else rows, work)
        return squares.view(np.float32), numbers

    def nearest_others(self, k: int, others: Others) -> Indices:
        """As `neighbors.Search` says."""
        from evastudio.learning.kernels.batches import search_others

        moments = _moments(others)
        found = np.empty((self._slots, k), np.int64)

        def work(first: int, last: int) -> None:
            search_others(self._address, first, last, k, moments, others.gap, found)

        share(self._leaves, LEAVES_EACH, work)
        return np.asarray(self._of_those_left(found))

    def median_deviations(self, actions: Array, k: int, others: Others) -> Array:
        """As `neighbors.Search` says."""
        from evastudio.learning.kernels.batches import deviations

        moments = _moments(others)
        found = np.empty(self._slots)

        def work(first: int, last: int) -> None:
            deviations(self._address, first, last, k, moments, others.gap, actions, found)

        share(self._leaves, LEAVES_EACH, work)
        return np.asarray(self._of_those_left(found))

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """As `neighbors.Search` says. Raises InvalidInputError for states of another width."""
        asked = self._asked
        if asked is None or asked[0] is not rule or asked[1] is not actions:
            self._ask(rule, actions)
        rows = len(states)
        out = np.empty((rows, self._outputs))
        if rows >= MANY and states.shape[1] == self._points.shape[1]:
            table = self._address
            share(rows, EACH, lambda first, last: decide_rows(table, states, first, last, out))
        elif not decide(self._address, states, out):
            raise InvalidInputError(
                f"The states have shape {states.shape}; expected (rows, {self._points.shape[1]})."
            )
        return out

    def add(self, points: Floats, first: int) -> None:
        """As `neighbors.Search` says."""
        count = len(points)
        self._points = np.concatenate([self._points, points])
        self._numbers = np.concatenate([self._numbers, np.arange(first, first + count)])
        self._slots = first + count
        self._waiting += count
        if self._waiting > max(WAITING, len(self._points) // 64):
            self._rebuild()
        else:
            self._pack_waiting()

    def remove(self, numbers: Indices) -> None:
        """As `neighbors.Search` says."""
        lines = np.searchsorted(self._numbers, numbers)  # they ascend
        self._waiting -= int((lines >= len(self._numbers) - self._waiting).sum())
        self._points = np.delete(self._points, lines, axis=0)
        self._numbers = np.delete(self._numbers, lines)
        places = self._places_of(numbers)
        self._tree.numbers.reshape(-1)[places] = NONE
        leaves, lanes = np.divmod(places, self._tree.numbers.shape[1])
        self._tree.leaves[leaves, :, lanes] = FAR
        self._gone += len(lines)
        if self._gone * 2 > len(self._points):
            self._rebuild()
        else:
            self._pack_waiting()

    def _places_of(self, numbers: Indices) -> Indices:
        """Where the tree's leaves hold those of the points `numbers` that it has."""
        if self._places is None:
            held = self._tree.numbers.reshape(-1)
            filled = np.flatnonzero(held != NONE)
            self._places = places = np.full(self._slots, NONE, dtype=np.int64)
            places[held[filled]] = filled
        places = self._places[numbers[numbers < len(self._places)]]
        return np.asarray(places[places != NONE])

    def _of_those_left(self, found: Any) -> Any:
        return found if len(self._numbers) == self._slots else found[self._numbers]

    def _rebuild(self) -> None:
        self._tree: Tree = build_tree(self._points, self._numbers)
        self._slots = int(self._numbers[-1]) + 1
        self._places = None
        self._waiting = self._gone = 0
        self._pack_waiting()

    def _pack_waiting(self) -> None:
        first = len(self._points) - self._waiting
        self._added = pack_leaves(self._points[first:], self._numbers[first:])
        self._lay_out()

    def _lay_out(self) -> None:
        """The table by which kernels find everything, see `kernels.tree`."""
        tree, (added, numbers) = self._tree, self._added
        self._table = np.zeros(TABLE, np.int64)
        self._table[:OFFSET] = (
            self._points.shape[1], len(tree.children), tree.nodes.ctypes.data,
            tree.children.ctypes.data, tree.leaves.ctypes.data, tree.numbers.ctypes.data,
            len(tree.leaves), added.ctypes.data, numbers.ctypes.data, len(added),
        )  # fmt: skip
        self._address = self._table.ctypes.data
        self._leaves = len(tree.leaves) + len(added)
        self._asked: tuple[Averaging, Array] | None = None

    def _ask(self, rule: Averaging, actions: Array) -> None:
        """Put what decides into the table, and keep it as long as its addresses stand there."""
        self._table[OFFSET:] = (
            rule.offset.ctypes.data, rule.scale.ctypes.data, actions.ctypes.data,
            actions.shape[1], rule.k, rule.inverse,
        )  # fmt: skip
        self._outputs = actions.shape[1]
        self._asked = rule, actions


def _moments(others: Others) -> Indices:
    return np.empty(0, np.int64) if others.moments is None else others.moments
