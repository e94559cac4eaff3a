"""A straight line through the neighbourhood: weighted ridge regression on the nearest pairs."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from evastudio.learning.checking import positive
from evastudio.learning.neighbor_learner import Continuous
from evastudio.world.spaces import Array

BLOCK = 250_000
"""Numbers of neighbours' states worked on at a time, to bound memory."""
FLOOR = 1e-12
"""Least ridge as a share of the mean square of the states: below it rounding would decide."""


class LocalLinearPolicy(Continuous):
    """A linear map fitted, for every decision anew, to the `k` nearest pairs.

    Pairs weigh by their distance (tricube of its ratio to the farthest), slopes are drawn to zero
    by `ridge`, and the answer stays within the actions of those pairs. Where the mapping slopes,
    this follows it with fewer pairs than a mean needs. Cleveland, "Robust locally weighted
    regression", 1979.

    Parameters
    ----------
    k : int
        How many pairs a decision is made from.
    ridge : float
        Weight of the slopes' squares, in units of the neighbours' total weight.

    Raises InvalidInputError for no pairs, NaN, wrong shapes, `k` above the number of pairs or
    1000.
    """

    most: ClassVar[int | None] = 1000

    def __init__(self, k: int = 40, ridge: float = 0.1) -> None:
        self.k = k
        self.ridge = ridge

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        actions = np.empty((len(states), self.actions_.shape[1]))
        size = max(1, BLOCK // (int(self.k) * self.states_.shape[1]))
        for start in range(0, len(states), size):
            rows = slice(start, start + size)
            actions[rows] = self._solve(states[rows])
        return actions

    def _solve(self, states: Array) -> Array:
        distances, pairs = self.nearest(states)
        weights = self.weigh(distances)[:, :, None]
        apart = self.states_[pairs] - self._scaling.apply(states)[:, None, :]
        given = self.actions_[pairs]
        middle = (weights * apart).sum(axis=1, keepdims=True)
        mean = (weights * given).sum(axis=1, keepdims=True)
        root = np.sqrt(weights)
        spread, wanted = root * (apart - middle), root * (given - mean)
        across = np.swapaxes(spread, 1, 2)
        # One small system for each query: a batch solves each as if it were alone. Its size is the
        # smaller of n and k, by (X'X + r)^-1 X' = X' (XX' + r)^-1.
        wide = apart.shape[2] > apart.shape[1]
        normal = spread @ across if wide else across @ spread
        size = normal.shape[1]
        trace = np.trace(normal, axis1=1, axis2=2)[:, None, None]
        normal += (self.ridge + FLOOR * trace / size) * np.eye(size)
        if wide:
            slopes = across @ np.linalg.solve(normal, wanted)
        else:
            slopes = np.linalg.solve(normal, across @ wanted)
        answers = np.where(
            np.isfinite(slopes).all(axis=1), (mean - middle @ slopes)[:, 0], mean[:, 0]
        )
        return np.asarray(np.clip(answers, given.min(axis=1), given.max(axis=1)))

    def weigh(self, distances: Array) -> Array:
        """Tricube weights, (queries, k), rows summing to 1."""
        reach = distances[:, -1:] * 1.001
        share = np.divide(distances, reach, out=np.zeros_like(distances), where=reach > 0.0)
        weights = (1.0 - share**3) ** 3
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        super().check_settings()
        positive(self, ridge=self.ridge)
