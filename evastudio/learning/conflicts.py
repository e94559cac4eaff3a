"""Conflict elimination: pairs that disagree with their neighbours (paper 3.1, figure 2, eq. 3)."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_pairs, positive
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array


class ConflictEliminator(BaseEstimator):  # type: ignore[misc]
    """Leaves out every pair whose action is far from the median action of its neighbours.

    For each pair: find its `n_neighbors` nearest others by standardised state (the pair itself
    is not among them), take the vector median of their actions (eq. 3), and mark the pair where
    its own action is farther than the threshold from that median. All marked pairs are left out
    together, at the end.

    Actions of several components are compared as vectors after each component has been divided
    by its own range, so the deviation is a Euclidean length in units of the range: with
    threshold 0.1 a pair of one-component actions is marked beyond 10 % of the range, and for
    more components beyond a combined 10 %.

    Parameters
    ----------
    n_neighbors : int
        Called l in the paper, which uses 5. Bursts of mistakes want more.
    threshold : float or "auto"
        Called eta in the paper, which uses about 0.1. "auto" finds it with Otsu's method on the
        deviations (between 0.05 and 0.5).
    action_range : array-like of shape (n_actions,) or None
        High minus low of each component; the observed range where None.

    Attributes (imbalanced-learn's sampler convention)
    ----------
    sample_indices_ : ndarray, the pairs that were kept
    conflict_mask_ : ndarray of bool, shape (n_pairs,), the pairs that were not
    deviations_ : ndarray of shape (n_pairs,), in units of the range
    threshold_ : float, as used
    range_ : ndarray of shape (n_actions,), as used

    Raises InvalidInputError for NaN, wrong shapes, and no more than `n_neighbors` pairs.
    """

    def __init__(
        self,
        n_neighbors: int = 5,
        threshold: float | str = 0.1,
        action_range: ArrayLike | None = None,
    ) -> None:
        self.n_neighbors = n_neighbors
        self.threshold = threshold
        self.action_range = action_range

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Find the conflicts among states (pairs, n) and actions (pairs, m) or (pairs,)."""
        if isinstance(self.n_neighbors, str) or self.n_neighbors != int(self.n_neighbors):
            raise InvalidInputError(
                f"n_neighbors is {self.n_neighbors!r}; it must be a whole number from 1 on."
            )
        positive(self, n_neighbors=self.n_neighbors)
        if self.threshold != "auto":
            positive(self, threshold=self.threshold)  # type: ignore[arg-type]
        states, actions = checked_pairs(self, states, actions)
        self.range_ = self._range(actions)
        scaled = actions / self.range_
        index = NeighborIndex(Scaling.of(states).apply(states))
        self.deviations_ = index.median_deviations(scaled, int(self.n_neighbors))
        if self.threshold == "auto":
            self.threshold_ = float(np.clip(otsu(self.deviations_), 0.05, 0.5))
        else:
            self.threshold_ = float(self.threshold)
        self.conflict_mask_ = self.deviations_ > self.threshold_
        self.sample_indices_ = np.flatnonzero(~self.conflict_mask_)
        return self

    def fit_resample(self, states: Any, actions: Any) -> tuple[Any, Any]:
        """The states and actions without the conflicts, in their order."""
        self.fit(states, actions)
        return np.asarray(states)[self.sample_indices_], np.asarray(actions)[self.sample_indices_]

    def _range(self, actions: Array) -> Array:
        if self.action_range is None:
            span = actions.max(axis=0) - actions.min(axis=0)
            return np.where(span > 0, span, 1.0)
        given = np.asarray(self.action_range, dtype=np.float64).reshape(-1)
        if given.shape != (actions.shape[1],) or not (np.isfinite(given) & (given > 0)).all():
            raise InvalidInputError(
                f"action_range is {self.action_range!r}; it must be {actions.shape[1]} numbers "
                "above 0, one for each component of the action."
            )
        return given


def otsu(values: NDArray[np.float64]) -> float:
    """The cut of `values` (n,) that parts them best: least variance within the two sides.

    Exact over all cuts, not binned. Otsu, "A threshold selection method from gray-level
    histograms", 1979. Returns the largest value where all are equal.
    """
    ordered = np.sort(values)
    count = np.arange(1, len(ordered))
    total = np.cumsum(ordered)
    low = total[:-1] / count
    high = (total[-1] - total[:-1]) / (len(ordered) - count)
    between = count * (len(ordered) - count) * (high - low) ** 2
    between[ordered[1:] == ordered[:-1]] = 0.0
    if len(between) == 0 or between.max() <= 0.0:
        return float(ordered[-1])
    best = int(between.argmax())
    return float((ordered[best] + ordered[best + 1]) / 2)
