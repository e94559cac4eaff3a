"""What learners that keep their pairs have in common: the pairs, the index, and why."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import (
    checked_actions,
    checked_indices,
    checked_pairs,
    checked_states,
)
from evastudio.learning.learner import SMALLEST, Layout, Reasons, Spread, Stored, agreement
from evastudio.learning.neighbors import Averaging, Indices, NeighborIndex, Way
from evastudio.learning.scaling import Scaling
from evastudio.learning.vector_regressor import VectorRegressor
from evastudio.world.spaces import Array, Box, Space, Symbols

WEIGHTS = ("uniform", "distance")


class NeighborLearner(BaseEstimator):  # type: ignore[misc]
    """Remembers standardised pairs and finds the `k` nearest to a state, exactly.

    Subclasses have a parameter `k` and say how `k` actions become one.
    """

    acts_in: ClassVar[type[Box] | type[Symbols]] = Box
    draws: ClassVar[bool] = False
    most: ClassVar[int | None] = None
    """The largest k that can be borne, where there is such."""

    k: int
    states_: Array
    """Standardised, shape (n_pairs, n_states)."""
    actions_: Array
    """Shape (n_pairs, n_actions)."""
    _spread: Spread | None

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

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """As `fit`, for actions (pairs, m) in the space `action`; `progress` hears nothing."""
        return self.fit(states, actions)

    def prepare(self, way: Way | None = None) -> Self:
        """Build the search tree from the fitted arrays; `fit` and loading a file call it."""
        self._index = NeighborIndex(self.states_, way)
        self._scaling = Scaling(self.offset_, self.scale_)
        self._slots = np.ascontiguousarray(self.actions_)
        self._spread = None
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
        if self._spread is not None:
            self._spread.add(more)
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
        if self._spread is not None:
            self._spread.add(self.actions_[gone], -1)
        self.states_ = np.delete(self.states_, gone, axis=0)
        self.actions_ = np.delete(self.actions_, gone, axis=0)
        return self

    def nearest(self, states: Array) -> tuple[Array, Indices]:
        """Standardised distances and indices of the k nearest pairs, each (queries, k)."""
        return self._index.nearest(self._scaling.apply(states), int(self.k))

    def explain(self, states: Any) -> Reasons:
        """The pairs behind each decision, how near they are, what they weigh, and if they agree."""
        check_is_fitted(self)
        distances, pairs = self.nearest(checked_states(self, states))
        weights = self.weigh(distances)
        agreed = agreement(self.actions_[pairs], weights, self._spread_of_all())
        return Reasons(pairs, distances, weights, agreed)

    def _spread_of_all(self) -> Spread:
        """Worked out when first asked for: it looks at every pair."""
        if self._spread is None:
            self._spread = Spread(self.actions_)
        return self._spread

    def weigh(self, distances: Array) -> Array:
        """What each neighbour counts, (queries, k), rows summing to 1: here all the same."""
        return np.full(distances.shape, 1.0 / distances.shape[1])

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        if not isinstance(self.k, (int, np.integer, float)) or self.k % 1 != 0 or self.k < 1:
            raise InvalidInputError(f"k is {self.k!r}; it must be a whole number from 1 on.")
        if self.most is not None and self.k > self.most:
            raise InvalidInputError(
                f"k is {self.k!r}; more than {self.most} would make every decision slow and are "
                "no neighbourhood any more."
            )

    def shown(self, pairs: Indices) -> Array | None:
        """The actions of the kept `pairs` (k,), (k, m)."""
        return self.actions_[pairs]

    @property
    def kept(self) -> Indices:
        """Which of the pairs it was fitted to it still has: all of them."""
        return np.arange(len(self.states_))

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file holds of it."""
        return (
            {
                "states": Stored(("pairs", "states")),
                "actions": Stored(("pairs", "actions")),
                "offset": Stored(("states",)),
                "scale": Stored(("states",), low=SMALLEST),
            },
        )

    def check_fitted(self) -> None:
        """Raise InvalidInputError where fitted arrays of the right shapes do not fit together."""
        if self.k > len(self.states_):
            raise InvalidInputError(
                f"it decides from k={self.k} pairs and holds {len(self.states_)}"
            )


class Averaged(NeighborLearner):
    """Of the learners here those that decide by an average over their neighbours."""

    weights: str
    """"uniform", or "distance" for one over the distance."""

    def prepare(self, way: Way | None = None) -> Self:
        """Build the search tree from the fitted arrays; `fit` and loading a file call it."""
        super().prepare(way)
        inverse = self.weights == "distance"
        self._rule = Averaging(self.offset_, self.scale_, int(self.k), inverse)
        return self

    def average(self, states: Array) -> Array:
        """Mean action of the neighbours of good states, bit for bit the same in any batch."""
        try:
            return self._index.search.average(states, self._rule, self._slots)
        except TypeError:  # cheaper than looking each time whether the array lies as it should
            states = np.ascontiguousarray(states, dtype=np.float64)
            return self._index.search.average(states, self._rule, self._slots)

    def weigh(self, distances: Array) -> Array:
        """What each neighbour counts, (queries, k), rows summing to 1."""
        if self.weights == "distance":
            return inverse_weights(distances)
        return super().weigh(distances)

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        super().check_settings()
        if self.weights not in WEIGHTS:
            raise InvalidInputError(
                f"weights is {self.weights!r}; it must be one of {', '.join(WEIGHTS)}."
            )


class Continuous(VectorRegressor, NeighborLearner):
    """Of the learners here those whose actions are real vectors."""


def inverse_weights(distances: Array) -> Array:
    """One over the distance, rows summing to 1; pairs at distance zero count alone."""
    same = distances == 0.0
    inverse = 1.0 / np.where(same, 1.0, distances)
    weights = np.where(same.any(axis=1, keepdims=True), same.astype(np.float64), inverse)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
