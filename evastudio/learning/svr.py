"""Epsilon-SVR with a Gaussian kernel, one function for each component of the action (paper 3.2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.svm import SVR
from sklearn.utils.validation import check_is_fitted

from evastudio.learning.checking import checked_pairs, checked_states, positive
from evastudio.learning.knn import Reasons
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array

BLOCK = 256
"""Queries answered at a time, so that the kernel matrix stays in cache."""


class SVRPolicy(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Smooth, compact policy: a sum of Gaussian bumps on standardised states.

    Each component of the action is divided by its observed half range and fitted on its own by
    scikit-learn; the support vectors of all are then joined, so that one kernel matrix answers
    for all components.

    Parameters
    ----------
    C : float
        How hard deviations beyond `epsilon` are punished.
    epsilon : float
        Deviation that costs nothing, as a share of half the action's range.
    gamma : float
        Narrowness of the bumps: exp(-gamma * squared standardised distance). In a good frame
        the kernel wants to be broad: 0.05 crosses far fewer fields than 0.01.
    cache_mb : float
        Memory for the solver's kernel cache.

    Attributes
    ----------
    support_ : ndarray of shape (n_support,), the pairs that became support vectors
    support_vectors_ : ndarray of shape (n_support, n_states), standardised
    coefficients_ : ndarray of shape (n_support, n_actions), in units of the action
    intercept_ : ndarray of shape (n_actions,)
    offset_, scale_ : ndarray of shape (n_states,), the standardisation

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and settings not above zero.
    """

    def __init__(
        self,
        C: float = 30.0,  # noqa: N803 - the literature's name
        epsilon: float = 0.2,
        gamma: float = 0.01,
        cache_mb: float = 400.0,
    ) -> None:
        self.C = C
        self.epsilon = epsilon
        self.gamma = gamma
        self.cache_mb = cache_mb

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def fit(
        self, states: Any, actions: Any = None, *, progress: Callable[[float], None] | None = None
    ) -> Self:
        """Fit to states (pairs, n) and actions (pairs, m) or (pairs,)."""
        self.check_settings()
        states, actions = checked_pairs(self, states, actions)
        scaling = Scaling.of(states)
        self.offset_, self.scale_ = scaling.offset, scaling.scale
        scaled = scaling.apply(states)
        half = (actions.max(axis=0) - actions.min(axis=0)) / 2
        half = np.where(half > 0, half, 1.0)
        middle = (actions.max(axis=0) + actions.min(axis=0)) / 2
        weights = np.zeros(actions.shape)
        self.intercept_ = np.zeros(actions.shape[1])
        for column in range(actions.shape[1]):
            machine = SVR(
                C=self.C, epsilon=self.epsilon, gamma=self.gamma, cache_size=self.cache_mb
            ).fit(scaled, (actions[:, column] - middle[column]) / half[column])
            weights[machine.support_, column] = machine.dual_coef_[0] * half[column]
            self.intercept_[column] = machine.intercept_[0] * half[column] + middle[column]
            if progress is not None:
                progress((column + 1) / actions.shape[1])
        self.support_ = np.flatnonzero((weights != 0).any(axis=1))
        self.support_vectors_ = scaled[self.support_]
        self.coefficients_ = weights[self.support_]
        return self.prepare()

    def prepare(self) -> Self:
        """Lay the fitted arrays out for `decide`; `fit` and loading a file call it."""
        self._scaling = Scaling(self.offset_, self.scale_)
        self._columns = np.ascontiguousarray(self.coefficients_.T)
        self._index: NeighborIndex | None = None
        return self

    def predict(self, states: Any) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so."""
        check_is_fitted(self)
        actions = self.decide(checked_states(self, states))
        return actions[:, 0] if self.flat_ else actions

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch.

        A matrix product would be faster, but BLAS rounds differently for different batches, and
        a world must not depend on which others run beside it.
        """
        scaled = self._scaling.apply(states)
        actions = np.empty((len(states), len(self._columns)))
        for start in range(0, len(states), BLOCK):
            rows = slice(start, start + BLOCK)
            kernel = cdist(scaled[rows], self.support_vectors_, "sqeuclidean")
            kernel *= -self.gamma
            np.exp(kernel, out=kernel)
            for column, weights in enumerate(self._columns):
                actions[rows, column] = (kernel * weights).sum(axis=1)
        return actions + self.intercept_

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        positive(self, C=self.C, epsilon=self.epsilon, gamma=self.gamma, cache_mb=self.cache_mb)

    def explain(self, states: Any) -> Reasons:
        """The support pair nearest to each state, as an index into the fitted pairs, and how far.

        Pairs that did not become support vectors are not kept, so the nearest pair of all may be
        nearer than this.
        """
        check_is_fitted(self)
        if self._index is None:
            self._index = NeighborIndex(self.support_vectors_)
        scaled = self._scaling.apply(checked_states(self, states))
        distances, nearest = self._index.nearest(scaled, 1)
        return Reasons(self.support_[nearest], distances)
