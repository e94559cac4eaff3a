"""Exact nearest neighbours in standardised states: one index, two ways to search it.

Points and queries are rounded to float32, and squared distances are float32 sums over the
components in order. Neighbours come nearest first; of points equally far the one with the lower
number is nearer. So the result equals a float64 brute force but for points whose distances agree
to about 1e-6 of their size, or that lie closer together than float32 can tell. Components beyond
1e15 count as 1e15.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.learning.compiled import is_compiled
from evastudio.world.spaces import Array

Indices = NDArray[np.int64]
Floats = NDArray[np.float32]
Way = Literal["compiled", "plain"]

LARGEST = 1e15


@dataclass(frozen=True)
class Averaging:
    """How a state becomes an action."""

    offset: Array
    """Subtracted from states, shape (n,)."""
    scale: Array
    """Then divided by, shape (n,)."""
    k: int
    inverse: bool
    """Neighbours weigh one over their distance; where some are at distance 0 only they count."""


class Search(Protocol):
    """A way to search points that are numbered for good."""

    def nearest(self, queries: Floats, k: int, skips: NDArray[np.int32]) -> tuple[Floats, Indices]:
        """Squared distances and numbers, each (queries, k).

        `skips` (queries,) or (0,) are numbers that do not count for their query.
        """

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """For states (rows, n) the mean action of their neighbours, (rows, m); `actions` by number.

        The answer to a state is the same, bit for bit, in every batch.
        """

    def add(self, points: Floats, first: int) -> None:
        """Search these too, numbered from `first` on."""

    def remove(self, numbers: Indices) -> None:
        """Find these no more."""


class NeighborIndex:
    """Points (n, d) that can be searched, added to and taken away from.

    `way` chooses between the compiled search and the plain one through SciPy, which give the same
    results, bit for bit; None takes the plain one until the compiled one is at hand.
    """

    def __init__(self, points: Array, way: Way | None = None) -> None:
        self._points = rounded(points)
        self._alive = np.ones(len(self._points), dtype=bool)
        self._ranks: Indices | None = None
        self.search: Search
        if way == "compiled" or (way is None and is_compiled()):
            from evastudio.learning.kernels.tree_search import TreeSearch  # slow to load

            self.search = TreeSearch(self._points)
        else:
            from evastudio.learning.plain_search import PlainSearch

            self.search = PlainSearch(self._points)

    def __len__(self) -> int:
        return len(self._points) if self._ranks is None else int(self._alive.sum())

    def nearest(self, queries: Array, k: int) -> tuple[Array, Indices]:
        """Distances and numbers, each (queries, k), of the `k` nearest points.

        Raises InvalidInputError where `k` is below 1 or above the number of points.
        """
        if not 1 <= k <= len(self):
            raise InvalidInputError(
                f"{k} neighbours were asked for, but there are {len(self)} pairs; choose from 1 "
                f"to {len(self)}."
            )
        squares, slots = self.search.nearest(rounded(queries), k, np.empty(0, np.int32))
        return np.sqrt(squares.astype(np.float64)), self._numbers(slots)

    def nearest_others(self, k: int) -> Indices:
        """The `k` nearest other points of every point, shape (n, k).

        Raises InvalidInputError where there are not `k` others.
        """
        if len(self) <= k:
            raise InvalidInputError(
                f"{k} neighbours of each pair were asked for, but there are only "
                f"{len(self)} (n_samples={len(self)}); at least {k + 1} are needed."
            )
        own = np.flatnonzero(self._alive).astype(np.int32)
        _, slots = self.search.nearest(self._points[own], k, own)
        return self._numbers(slots)

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """Mean actions (rows, m) for states (rows, n) as they are before standardisation.

        `actions` (slots, m) holds an action for every point that ever was, see `slots`.
        """
        return self.search.average(states, rule, actions)

    def add(self, points: Array) -> None:
        """Put more points behind those there are."""
        more = rounded(points)
        self.search.add(more, len(self._points))
        self._points = np.concatenate([self._points, more])
        self._alive = np.concatenate([self._alive, np.ones(len(more), dtype=bool)])
        if self._ranks is not None:
            self._ranks = np.cumsum(self._alive) - 1

    def remove(self, numbers: Indices) -> None:
        """Take the points of those numbers away; those behind them move up."""
        slots = self.slots(numbers)
        self.search.remove(slots)
        self._alive[slots] = False
        self._ranks = np.cumsum(self._alive) - 1

    def slots(self, numbers: Indices) -> Indices:
        """Where the search keeps the points of those numbers."""
        return np.flatnonzero(self._alive)[numbers]

    def _numbers(self, slots: Indices) -> Indices:
        return slots if self._ranks is None else self._ranks[slots]


def rounded(values: Array) -> Floats:
    """`values` (n, d) as the float32 that are searched."""
    return np.ascontiguousarray(np.clip(values, -LARGEST, LARGEST), dtype=np.float32)
