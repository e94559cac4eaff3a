"""The plain way to search: SciPy's k-d tree, brought to the float32 rule of `neighbors`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from evastudio.learning.neighbors import Averaging, Floats, Indices, Others, rounded
from evastudio.world.spaces import Array

MORE = 4
"""Neighbours looked at beyond those wanted, so that most ties need no second look."""
SLACK = 1.0 + 1e-5
"""Float32 distances are this close to exact ones."""
BLOCK = 4096
"""Points whose neighbours are looked at together, to bound memory."""


class PlainSearch:
    """See `neighbors.Search`. Adding and removing make the tree anew at the next search."""

    def __init__(self, points: Floats) -> None:
        self._points = points
        self._numbers = np.arange(len(points))
        self._tree: cKDTree | None = None

    def nearest(self, queries: Floats, k: int) -> tuple[Floats, Indices]:
        """As `neighbors.Search` says."""
        return self._nearest(queries, k, None, None)

    def nearest_others(self, k: int, others: Others) -> Indices:
        """As `neighbors.Search` says."""
        found = np.empty((len(self._points), k), np.int64)
        for rows in self._blocks():
            found[rows] = self._nearest(self._points[rows], k, others, self._numbers[rows])[1]
        return found

    def median_deviations(self, actions: Array, k: int, others: Others) -> Array:
        """As `neighbors.Search` says."""
        deviations = np.empty(len(self._points))
        for rows in self._blocks():
            own = self._numbers[rows]
            found = self._nearest(self._points[rows], k, others, own)[1]
            deviations[rows] = lengths(vector_medians(actions[found]) - actions[own])
        return deviations

    def _blocks(self) -> Iterator[slice]:
        """All points, some at a time, to bound memory."""
        return (slice(at, at + BLOCK) for at in range(0, len(self._points), BLOCK))

    def _nearest(
        self, queries: Floats, k: int, others: Others | None, own: Indices | None
    ) -> tuple[Floats, Indices]:
        """The nearest points to each query; with `others` those that count for the point `own`."""
        if self._tree is None:
            self._tree = cKDTree(self._points.astype(np.float64))
        points, numbers = self._points, self._numbers
        wanted = min(k + (0 if others is None else others.most) + MORE, len(points))
        far, rows = self._tree.query(queries.astype(np.float64), k=np.arange(1, wanted + 1))
        squares = squared(points[rows], queries[:, None, :])
        if others is not None and own is not None:
            squares[others.none(own, numbers[rows])] = np.inf
        order = np.lexsort((numbers[rows], squares), axis=1)[:, :k]
        best = np.take_along_axis(squares, order, axis=1)
        chosen = np.take_along_axis(numbers[rows], order, axis=1)
        # Whatever is as near as the k-th, but was not looked at, may come first by its number.
        reach = np.sqrt(best[:, -1].astype(np.float64)) * SLACK
        open_rows = (far[:, -1] <= reach) & (wanted < len(points))
        for row in np.flatnonzero(open_rows):
            ball = np.asarray(self._tree.query_ball_point(queries[row], reach[row]), dtype=np.int64)
            if others is not None and own is not None:
                ball = ball[~others.none(own[row : row + 1], numbers[ball][None])[0]]
            near = squared(points[ball], queries[row])
            first = np.lexsort((numbers[ball], near))[:k]
            best[row], chosen[row] = near[first], numbers[ball[first]]
        return best, chosen

    def average(self, states: Array, rule: Averaging, actions: Array) -> Array:
        """As `neighbors.Search` says."""
        queries = rounded((states - rule.offset) / rule.scale)
        squares, numbers = self.nearest(queries, rule.k)
        weights = np.full(squares.shape, 1.0 / rule.k)
        if rule.inverse:
            same = squares == 0.0
            apart = np.sqrt(np.where(same, 1.0, squares.astype(np.float64)))
            weights = np.where(
                same.any(axis=1, keepdims=True), same.astype(np.float64), 1.0 / apart
            )
            total = np.zeros(len(states))
            for rank in range(rule.k):
                total += weights[:, rank]
            weights /= total[:, None]
        mean = np.zeros((len(states), actions.shape[1]))
        for rank in range(rule.k):  # in this order, as the compiled way adds
            mean += weights[:, rank, None] * actions[numbers[:, rank]]
        return mean

    def add(self, points: Floats, first: int) -> None:
        """As `neighbors.Search` says."""
        self._points = np.concatenate([self._points, points])
        self._numbers = np.concatenate([self._numbers, np.arange(first, first + len(points))])
        self._tree = None

    def remove(self, numbers: Indices) -> None:
        """As `neighbors.Search` says."""
        kept = ~np.isin(self._numbers, numbers)
        self._points, self._numbers = self._points[kept], self._numbers[kept]
        self._tree = None


def squared(points: Floats, queries: Floats) -> Floats:
    """Squared distances, summed in float32 over the last axis in order."""
    apart = points - queries
    total = np.zeros(apart.shape[:-1], np.float32)
    for component in range(apart.shape[-1]):
        total += apart[..., component] * apart[..., component]
    return total


def vector_medians(actions: Array) -> Array:
    """The vector median of each set (eq. 3): `actions` (sets, l, m) gives (sets, m).

    It is the member with the least sum of Euclidean distances to all; the first of several.
    """
    between = lengths(actions[:, :, None, :] - actions[:, None, :, :])
    total = np.zeros(between.shape[:2])
    for other in range(between.shape[2]):  # in this order, as the compiled way adds
        total += between[:, :, other]
    best = total.argmin(axis=1)
    return np.asarray(actions[np.arange(len(actions)), best])


def lengths(vectors: Array) -> Array:
    """Euclidean lengths of `vectors` (..., m), shape (...), summed over the components in order."""
    total = np.zeros(vectors.shape[:-1])
    for component in range(vectors.shape[-1]):
        total += vectors[..., component] * vectors[..., component]
    return np.sqrt(total)
