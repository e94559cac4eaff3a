"""Voting k-nearest neighbour, for actions that are symbols (paper, section 3)."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from sklearn.base import ClassifierMixin
from sklearn.utils import assert_all_finite
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, column_or_1d

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_states
from evastudio.learning.neighbor_learner import Averaged
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array


class VotingKNNPolicy(ClassifierMixin, Averaged):  # type: ignore[misc]
    """The symbol that most of the `k` nearest pairs were answered with.

    Of symbols with equally many votes the first in `classes_` wins.

    Parameters
    ----------
    k : int
        How many pairs vote.
    weights : {"uniform", "distance"}
        Whether all votes count the same, or each by one over its distance.

    Attributes
    ----------
    classes_ : ndarray, the symbols, sorted
    actions_ : ndarray of shape (n_pairs, n_classes), 1 for the symbol of a pair

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and `k` above the number of pairs.
    """

    def __init__(self, k: int = 5, weights: str = "uniform") -> None:
        self.k = k
        self.weights = weights

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Remember the pairs: states (pairs, n), symbols (pairs,)."""
        if actions is None:
            raise InvalidInputError(
                f"{type(self).__name__} requires y to be passed, but the target y is None: "
                "give a symbol for every state."
            )
        try:
            symbols = column_or_1d(actions, warn=True)
            assert_all_finite(symbols, input_name="y")
            check_classification_targets(symbols)
        except ValueError as error:
            raise InvalidInputError(f"These symbols cannot be learned: {error}") from None
        self.classes_, codes = np.unique(symbols, return_inverse=True)
        return super().fit(states, np.eye(len(self.classes_))[codes])

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs without fitting anew; their symbols must be known ones."""
        check_is_fitted(self)
        symbols = np.asarray(actions)
        known = np.isin(symbols, self.classes_)
        if not known.all():
            raise InvalidInputError(
                f"The symbol {str(symbols[~known][0])!r} was not among those fitted "
                f"({', '.join(map(str, self.classes_))}); fit anew to add one."
            )
        return super().add_pairs(
            states, np.eye(len(self.classes_))[np.searchsorted(self.classes_, symbols)]
        )

    def predict(self, states: Any) -> AnyArray:
        """Symbols (queries,) for states (queries, n)."""
        votes = self.predict_proba(states)
        return np.asarray(self.classes_[votes.argmax(axis=1)])

    def predict_proba(self, states: Any) -> Array:
        """Shares of the votes, (queries, n_classes)."""
        check_is_fitted(self)
        asked = checked_states(self, states)
        votes: Array = self._index.average(asked, self._rule, self._slots)
        return votes

    def decide(self, states: Array) -> Array:
        """Codes of the symbols, (queries, 1), for states known to be good."""
        votes = self._index.average(states, self._rule, self._slots)
        return np.asarray(votes.argmax(axis=1)[:, None], dtype=np.float64)
