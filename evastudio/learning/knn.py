"""Continuous k-nearest neighbour: the mean action of the most similar pairs (paper 3.2)."""

from __future__ import annotations

from typing import Any, Self

from sklearn.base import RegressorMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_states
from evastudio.learning.neighbor_learner import NeighborLearner, inverse_weights
from evastudio.learning.neighbors import Averaging, Way
from evastudio.world.spaces import Array

WEIGHTS = ("uniform", "distance")


class KNNPolicy(RegressorMixin, NeighborLearner):  # type: ignore[misc]
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

    def prepare(self, way: Way | None = None) -> Self:
        """Build the search tree from the fitted arrays; `fit` and loading a file call it."""
        super().prepare(way)
        inverse = self.weights == "distance"
        self._rule = Averaging(self.offset_, self.scale_, int(self.k), inverse)
        return self

    def predict(self, states: Any) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so."""
        check_is_fitted(self)
        actions = self.decide(checked_states(self, states))
        flat: Array = actions[:, 0]
        return flat if self.flat_ else actions

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        return self._index.average(states, self._rule, self._slots)

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
