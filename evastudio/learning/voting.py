"""Voting k-nearest neighbour, for actions that are symbols (paper, section 3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import ClassifierMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_states, checked_symbols, checked_targets
from evastudio.learning.learner import Indices, Layout, Stored
from evastudio.learning.neighbor_learner import Averaged
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array, Box, Space, Symbols


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

    acts_in: ClassVar[type[Box] | type[Symbols]] = Symbols

    def __init__(self, k: int = 5, weights: str = "uniform") -> None:
        self.k = k
        self.weights = weights

    def fit(self, states: Any, actions: Any = None, *, classes: ArrayLike | None = None) -> Self:
        """Remember the pairs: states (pairs, n), symbols (pairs,).

        `classes` are all the symbols there are, sorted, where not each of them was shown.
        """
        symbols = checked_targets(self, actions)
        known = np.unique(symbols if classes is None else np.asarray(classes))
        ballots = self._ballots(symbols, known)
        self.classes_ = known
        return super().fit(states, ballots)

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """As `fit`, for codes (pairs, 1) of the symbols of `action`."""
        return self.fit(states, actions[:, 0], classes=np.arange(float(len(action.names))))

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs without fitting anew; their symbols must be known ones."""
        check_is_fitted(self)
        return super().add_pairs(states, self._ballots(np.ravel(actions), self.classes_))

    def _ballots(self, symbols: AnyArray, known: AnyArray) -> Array:
        """For each symbol a row with 1 in its column, shape (symbols, known)."""
        return np.asarray(np.eye(len(known))[checked_symbols(symbols, known)])

    def predict(self, states: Any) -> AnyArray:
        """Symbols (queries,) for states (queries, n)."""
        votes = self.predict_proba(states)
        return np.asarray(self.classes_[votes.argmax(axis=1)])

    def predict_proba(self, states: Any) -> Array:
        """Shares of the votes, (queries, n_classes)."""
        check_is_fitted(self)
        asked = checked_states(self, states)
        return self.average(asked)

    def decide(self, states: Array, draws: Array | None = None) -> Array:
        """Codes of the symbols, their places in `classes_`, (queries, 1), for good states.

        `draws` (queries,) in [0, 1) draw among the votes instead of counting them.
        """
        votes = self.average(states)
        if draws is None:
            codes = votes.argmax(axis=1)
        else:
            past = np.cumsum(votes, axis=1) > draws[:, None]
            past[:, -1] = True  # rounding can leave the sum of all short of 1
            codes = past.argmax(axis=1)
        return np.asarray(codes[:, None], dtype=np.float64)

    def shown(self, pairs: Indices) -> Array:
        """Codes of the symbols of the kept `pairs` (k,), (k, 1)."""
        return np.asarray(self.actions_[pairs].argmax(axis=1)[:, None], dtype=np.float64)

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file holds of it."""
        (layout,) = super().layouts()
        ballots = Stored(("pairs", "actions"), np.uint8)
        return ({**layout, "actions": ballots, "classes": Stored(("actions",))},)

    def check_fitted(self) -> None:
        """Raise InvalidInputError where fitted arrays of the right shapes do not fit together."""
        super().check_fitted()
        if not np.array_equal(self.classes_, np.arange(len(self.classes_))):
            raise InvalidInputError("its symbols are not those of its action")
        if not ((self.actions_ <= 1.0) & (self.actions_.sum(axis=1, keepdims=True) == 1.0)).all():
            raise InvalidInputError("a pair of it has not exactly one symbol")


class SampledVotingPolicy(VotingKNNPolicy):
    """A symbol drawn among the votes of the `k` nearest pairs, as often as each was shown there.

    A crowd that counts votes does the commonest thing everywhere; one that draws keeps what was
    rare but shown (paper, section 5). Asked by `predict`, without a draw, it counts. Parameters,
    attributes and errors are those of `VotingKNNPolicy`.
    """

    draws: ClassVar[bool] = True
