"""Continuous k-nearest neighbour: the mean action of the most similar pairs (paper 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_pairs, checked_states
from evastudio.learning.neighbors import Indices, NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array

WEIGHTS = ("uniform", "distance")


@dataclass(frozen=True)
class Reasons:
    """Why a learner decided as it did."""

    pairs: Indices
    """Indices of the pairs that a decision came from, nearest first, shape (queries, k)."""
    distances: Array
    """How far each of them is from the state asked about, standardised, shape (queries, k)."""


class KNNPolicy(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Mean action of the `k` nearest pairs by standardised state.

    Search is exact and Euclidean; of pairs equally far, the one recorded first counts first.

    Parameters
    ----------
    k : int
        How many pairs a decision is made from. The paper used 2 to 7.
    weights : {"uniform", "distance"}
        Whether all k count the same, or each by one over its distance (a pair at distance zero
        then decides alone).

    Attributes
    ----------
    states_ : ndarray of shape (n_pairs, n_states), standardised
    actions_ : ndarray of shape (n_pairs, n_actions)
    offset_, scale_ : ndarray of shape (n_states,), the standardisation

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and `k` above the number of pairs.
    """

    def __init__(self, k: int = 5, weights: str = "uniform") -> None:
        self.k = k
        self.weights = weights

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Remember the pairs: states (pairs, n), actions (pairs, m) or (pairs,)."""
        self.check_settings()
        states, actions = checked_pairs(self, states, actions)
        if self.k > len(states):
            raise InvalidInputError(
                f"Each decision was to be made from k={self.k} pairs, but there are only "
                f"{len(states)} (n_samples={len(states)}); record more, or choose a smaller k."
            )
        scaling = Scaling.of(states)
        self.offset_, self.scale_ = scaling.offset, scaling.scale
        self.states_ = scaling.apply(states)
        self.actions_ = actions
        return self.prepare()

    def prepare(self) -> Self:
        """Build the search tree from the fitted arrays; `fit` and loading a file call it."""
        self._index = NeighborIndex(self.states_)
        self._scaling = Scaling(self.offset_, self.scale_)
        return self

    def predict(self, states: Any) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so."""
        check_is_fitted(self)
        actions = self.decide(checked_states(self, states))
        return actions[:, 0] if self.flat_ else actions

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        distances, pairs = self._index.nearest(self._scaling.apply(states), int(self.k))
        weights = self._weigh(distances)
        total = np.zeros((len(states), self.actions_.shape[1]))
        for rank in range(pairs.shape[1]):  # in this order, so that batches of any size agree
            total += weights[:, rank, None] * self.actions_[pairs[:, rank]]
        return total

    def explain(self, states: Any) -> Reasons:
        """The pairs behind each decision and how near they are."""
        check_is_fitted(self)
        scaled = self._scaling.apply(checked_states(self, states))
        distances, pairs = self._index.nearest(scaled, int(self.k))
        return Reasons(pairs, distances)

    def _weigh(self, distances: Array) -> Array:
        if self.weights == "uniform":
            return np.full(distances.shape, 1.0 / distances.shape[1])
        exact = distances == 0.0
        inverse = 1.0 / np.where(exact, 1.0, np.maximum(distances, 1e-300))
        weights = np.where(exact.any(axis=1, keepdims=True), exact.astype(np.float64), inverse)
        total = np.zeros(len(weights))
        for rank in range(weights.shape[1]):
            total += weights[:, rank]
        return np.asarray(weights / total[:, None])

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        if not isinstance(self.k, (int, np.integer, float)) or self.k % 1 != 0 or self.k < 1:
            raise InvalidInputError(f"k is {self.k!r}; it must be a whole number from 1 on.")
        if self.weights not in WEIGHTS:
            raise InvalidInputError(
                f"weights is {self.weights!r}; it must be one of {', '.join(WEIGHTS)}."
            )
