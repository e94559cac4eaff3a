"""What learners share that fit one function to all pairs: the SVR, and the neural network."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_indices, checked_states
from evastudio.learning.learner import Indices, Reasons, Spread, agreement
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.learning.vector_regressor import VectorRegressor
from evastudio.world.spaces import Array, Box, Symbols

NEIGHBORS = 5
"""How many demonstrations an explanation names."""


class GlobalRegressor(VectorRegressor, BaseEstimator, ABC):  # type: ignore[misc]
    """Predicts, explains and checks pairs to be forgotten, for learners that may keep none."""

    acts_in: ClassVar[type[Box] | type[Symbols]] = Box
    draws: ClassVar[bool] = False
    states_: Array
    """Standardised, where it has pairs."""
    actions_: Array
    """As given, where it has pairs."""
    _scaling: Scaling
    _index: NeighborIndex | None
    _spread: Spread
    """Of the actions, where there are any, as soon as `_index` is there."""

    def explain(self, states: Any) -> Reasons:
        """The nearest demonstrations, how much each weighs, and whether they agree.

        Of one that has none nothing is told.
        """
        check_is_fitted(self)
        asked = self._scaling.apply(checked_states(self, states))
        if self._index is None:
            shown = self._shown()
            if len(shown) == 0:
                nothing = np.empty((len(asked), 0))
                return Reasons(nothing.astype(np.int64), nothing, nothing, None)
            self._index = NeighborIndex(shown)
            if hasattr(self, "actions_"):
                self._spread = Spread(self.actions_)
        distances, nearest = self._index.nearest(asked, min(NEIGHBORS, len(self._index)))
        weights = self._weights(distances)
        if not hasattr(self, "actions_"):
            return Reasons(nearest, distances, weights, None)
        agreed = agreement(self.actions_[nearest], weights, self._spread)
        return Reasons(nearest, distances, weights, agreed)

    def shown(self, pairs: Indices) -> Array | None:
        """The actions of the kept `pairs` (k,), (k, m); None where it keeps no pairs."""
        return self.actions_[pairs] if hasattr(self, "actions_") else None

    @abstractmethod
    def _shown(self) -> Array:
        """The standardised states that explanations name, (any, n)."""

    @abstractmethod
    def _weights(self, distances: Array) -> Array:
        """How much demonstrations at these `distances` (queries, some) weigh; rows sum to 1."""

    def _forgotten(self, pairs: ArrayLike) -> Indices:
        """The indices `pairs` into `states_`, of which some must be left."""
        gone = checked_indices(pairs, len(self.states_))
        if len(gone) == len(self.states_):
            raise InvalidInputError(f"Removing all {len(gone)} pairs leaves none to learn from.")
        return gone
