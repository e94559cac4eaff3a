"""Exact nearest neighbours in standardised states: one index, two ways to search it.

Points and queries are rounded to float32, and squared distances are float32 sums over the
components in order. Neighbours come nearest first; of points equally far the one with the lower
number is nearer. So the result equals a float64 brute force but for points whose distances agree
to about 1e-6 of their size, or that lie closer together than float32 can tell. Components beyond
1e15 count as 1e15.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.compiled import is_compiled
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


@dataclass(frozen=True)
class Others:
    """Which points count as neighbours of a point."""

    moments: Indices | None
    """When each was, by number; None where only the point itself does not count."""
    gap: int
    """Points no more than this from its own moment do not count."""
    most: int
    """How many points at most do not count for some point."""

    def none(self, own: Indices, found: Indices) -> NDArray[np.bool_]:
        """Which of `found` (rows, any) do not count for the points `own` (rows,)."""
        if self.moments is None:
            return np.asarray(found == own[:, None])
        return np.asarray(abs(self.moments[found] - self.moments[own][:, None]) <= self.gap)


class Search(Protocol):
    """A way to search points that are numbered for good."""

    def nearest(self, queries: Floats, k: int) -> tuple[Floats, Indices]:
        """Squared distances and numbers, each (queries, k)."""

    def nearest_others(self, k: int, others: Others) -> Indices:
        """Numbers (n, k) of the neighbours of every point, in the order of their numbers."""

    def median_deviations(self, actions: Array, k: int, others: Others) -> Array:
        """For every point (n,) how far its action is from the vector median of its neighbours'.

        `actions` (slots, m) by number.
        """

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """For states (rows, n) the mean action of their neighbours, (rows, m).

        States are as they were before standardisation; `actions` (slots, m) holds an action for
        every point that ever was, see `NeighborIndex.slots`. The answer to a state is the same,
        bit for bit, in every batch.
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
        squares, slots = self.search.nearest(rounded(queries), k)
        return np.sqrt(squares.astype(np.float64)), self._numbers(slots)

    def nearest_others(self, k: int, moments: Indices | None = None, gap: int = 0) -> Indices:
        """The `k` nearest other points of every point, shape (n, k).

        With `moments` (n,), points whose moment is within `gap` of the asker's own do not count.
        Raises InvalidInputError where some point has fewer than `k` others that count.
        """
        return self._numbers(self.search.nearest_others(k, self._others(k, moments, gap)))

    def median_deviations(
        self, actions: Array, k: int, moments: Indices | None = None, gap: int = 0
    ) -> Array:
        """How far each action (n, m) is from the vector median of its `k` neighbours', shape (n,).

        The neighbours are those of `nearest_others`. The vector median (paper eq. 3) is the one
        with the least sum of Euclidean distances to all of them; of several the nearest neighbour.
        Raises InvalidInputError as `nearest_others` does.
        """
        others = self._others(k, moments, gap)
        return self.search.median_deviations(self._by_slot(actions), k, others)

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

    def _others(self, k: int, moments: Indices | None, gap: int) -> Others:
        """What counts as a neighbour, once it is sure that every point has `k` of them."""
        count = len(self)
        if k < 1 or gap < 0:
            raise InvalidInputError(
                f"{k} neighbours at least {gap} moments away were asked for; ask for 1 or more, "
                "and a gap of 0 or more."
            )
        if moments is None:
            most = 1
        else:
            moments = np.asarray(moments, dtype=np.int64)
            if moments.shape != (count,):
                raise InvalidInputError(
                    f"The moments have shape {moments.shape}; expected one for each of the "
                    f"{count} pairs."
                )
            ordered = np.sort(moments)
            close = np.searchsorted(ordered, ordered + gap, "right")
            most = int((close - np.searchsorted(ordered, ordered - gap, "left")).max(initial=0))
            moments = self._by_slot(moments)
        if count - most < k:
            reason = "" if moments is None else f", of which up to {most} are too close in time"
            raise InvalidInputError(
                f"{k} neighbours of each pair were asked for, but there are only "
                f"{count} (n_samples={count}){reason}; at least {k + most} are needed."
            )
        return Others(moments, gap, most)

    def _by_slot(self, values: Any) -> Any:
        """`values` (n, ...), one for each point, laid out as the search numbers them."""
        if self._ranks is None:
            return np.ascontiguousarray(values)
        spread = np.zeros((len(self._points), *values.shape[1:]), values.dtype)
        spread[self._alive] = values
        return spread

    def _numbers(self, slots: Indices) -> Indices:
        return slots if self._ranks is None else self._ranks[slots]


def rounded(values: Array) -> Floats:
    """`values` (n, d) as the float32 that are searched."""
    return np.ascontiguousarray(np.clip(values, -LARGEST, LARGEST), dtype=np.float32)
