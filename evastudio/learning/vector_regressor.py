"""What all learners share whose actions are real vectors, as scikit-learn wants it."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from sklearn.base import RegressorMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.learning.checking import checked_states
from evastudio.world.spaces import Array


class VectorRegressor(RegressorMixin):  # type: ignore[misc]
    """Predicts one action or several at once. Subclasses say `decide`, and set `flat_` in `fit`."""

    flat_: bool
    """Whether it was fitted to actions of shape (pairs,)."""

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def predict(self, states: Any) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so."""
        check_is_fitted(self)
        actions = self.decide(checked_states(self, states))
        return actions[:, 0] if self.flat_ else actions

    @abstractmethod
    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
