"""Continuous k-nearest neighbour: the mean action of the most similar pairs (paper 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import (
    checked_actions,
    checked_indices,
    checked_pairs,
    checked_states,
)
from evastudio.learning.neighbors import Averaging, Indices, NeighborIndex, Way
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

    def prepare(self, way: Way | None = None) -> Self:
        """Build the search tree from the fitted arrays; `fit` and loading a file call it."""
        self._index = NeighborIndex(self.states_, way)
        self._scaling = Scaling(self.offset_, self.scale_)
        self._slots = np.ascontiguousarray(self.actions_)
        self._rule = Averaging(
            self.offset_, self.scale_, int(self.k), inverse=self.weights == "distance"
        )
        return self

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs without fitting anew; the standardisation stays as it was fitted.

        states: shape (more, n). actions: shape (more, m), or (more,) where fitted so.
        """
        check_is_fitted(self)
        scaled = self._scaling.apply(checked_states(self, states))
        more = checked_actions(actions, len(scaled), self.actions_.shape[1])
        self._index.add(scaled)
        self.states_ = np.concatenate([self.states_, scaled])
        self.actions_ = np.concatenate([self.actions_, more])
        self._slots = np.concatenate([self._slots, more])
        return self

    def remove_pairs(self, pairs: ArrayLike) -> Self:
        """Forget the pairs of these indices into `states_`; those behind them move up.

        Raises InvalidInputError for indices that are none, and where fewer than k would be left.
        """
        check_is_fitted(self)
        gone = checked_indices(pairs, len(self.states_))
        if len(self.states_) - len(gone) < self.k:
            raise InvalidInputError(
                f"Removing {len(gone)} of {len(self.states_)} pairs leaves fewer than the "
                f"k={self.k} that a decision is made from; choose a smaller k or keep more."
            )
        self._index.remove(gone)
        self.states_ = np.delete(self.states_, gone, axis=0)
        self.actions_ = np.delete(self.actions_, gone, axis=0)
        return self

    def predict(self, states: Any) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so."""
        check_is_fitted(self)
        actions = self.decide(checked_states(self, states))
        return actions[:, 0] if self.flat_ else actions

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        return self._index.average(states, self._rule, self._slots)

    def explain(self, states: Any) -> Reasons:
        """The pairs behind each decision and how near they are."""
        check_is_fitted(self)
        scaled = self._scaling.apply(checked_states(self, states))
        distances, pairs = self._index.nearest(scaled, int(self.k))
        return Reasons(pairs, distances)

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        if not isinstance(self.k, (int, np.integer, float)) or self.k % 1 != 0 or self.k < 1:
            raise InvalidInputError(f"k is {self.k!r}; it must be a whole number from 1 on.")
        if self.weights not in WEIGHTS:
            raise InvalidInputError(
                f"weights is {self.weights!r}; it must be one of {', '.join(WEIGHTS)}."
            )
