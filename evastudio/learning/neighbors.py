"""Exact nearest neighbours in standardised states, with a stated rule for ties."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from evastudio.errors import InvalidInputError
from evastudio.world.spaces import Array

Indices = NDArray[np.int64]


class NeighborIndex:
    """A k-d tree over points (n, d): Euclidean, float64, exact.

    Neighbours come in order of distance; of points at exactly equal distance the one with the
    lowest index comes first, and is the one kept where only some of them fit.
    """

    def __init__(self, points: Array) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        self._tree = cKDTree(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def nearest(self, queries: Array, k: int) -> tuple[Array, Indices]:
        """Distances and indices, each (queries, k), of the `k` nearest points.

        Raises InvalidInputError where `k` is below 1 or above the number of points.
        """
        if not 1 <= k <= len(self):
            raise InvalidInputError(
                f"{k} neighbours were asked for, but there are {len(self)} pairs; choose from 1 "
                f"to {len(self)}."
            )
        wanted = min(k + 1, len(self))
        distances, indices = self._tree.query(queries, k=np.arange(1, wanted + 1))
        distances, indices = np.asarray(distances), np.asarray(indices, dtype=np.int64)
        tied = (distances[:, 1:] == distances[:, :-1]).any(axis=1)
        distances, indices = distances[:, :k].copy(), indices[:, :k].copy()
        for row in np.flatnonzero(tied):
            # A little wider than the k-th, so that rounding in the tree cannot lose a tie.
            radius = distances[row, -1] * (1.0 + 1e-9)
            ball = np.asarray(self._tree.query_ball_point(queries[row], radius), dtype=np.int64)
            away = np.sqrt(((self.points[ball] - queries[row]) ** 2).sum(axis=1))
            order = np.lexsort((ball, away))[:k]
            distances[row], indices[row] = away[order], ball[order]
        return distances, indices

    def nearest_others(self, k: int) -> Indices:
        """The `k` nearest other points of every point, shape (n, k).

        Raises InvalidInputError where there are not `k` others.
        """
        if len(self) <= k:
            raise InvalidInputError(
                f"{k} neighbours of each pair were asked for, but there are only "
                f"{len(self)} (n_samples={len(self)}); at least {k + 1} are needed."
            )
        _, indices = self.nearest(self.points, k + 1)
        own = indices == np.arange(len(self))[:, None]
        # Where more than k others lie at distance zero, the point itself may not be listed.
        own[~own.any(axis=1), k] = True
        others: Indices = indices[~own].reshape(len(self), k)
        return others
