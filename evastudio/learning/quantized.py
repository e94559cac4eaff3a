"""Learners of numbers that decide among symbols: their answer is quantised (paper, section 4.2).

Each symbol stands for a move, a vector of real numbers. The moves that were shown are learned as
numbers are, and the symbol is chosen whose move is nearest to the answer. Between two symbols that
were shown alike often such a learner may choose a third that lies between them, which votes never
do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import ClassifierMixin
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_states, checked_symbols, checked_targets
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.learner import Indices, Layout, Stored
from evastudio.learning.svr import SVRPolicy
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array, Box, Space, Symbols


class Quantized(ClassifierMixin):  # type: ignore[misc]
    """What makes a learner of numbers, the next class in line, one of symbols.

    Attributes
    ----------
    classes_ : ndarray, the symbols, sorted
    moves_ : ndarray of shape (n_classes, n_components), what each stands for
    """

    acts_in: ClassVar[type[Box] | type[Symbols]] = Symbols

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = False
        return tags

    def fit(
        self,
        states: Any,
        actions: Any = None,
        *,
        classes: ArrayLike | None = None,
        moves: ArrayLike | None = None,
    ) -> Self:
        """Fit to states (pairs, n) and symbols (pairs,).

        `classes` are all the symbols there are, sorted, where not each was shown; `moves` (classes,
        m) what each stands for, without which each is a direction of its own.
        """
        symbols = checked_targets(self, actions)
        self.classes_ = np.unique(symbols if classes is None else np.asarray(classes))
        self.moves_ = (
            np.eye(len(self.classes_)) if moves is None else np.asarray(moves, dtype=np.float64)
        )
        fitted: Self = super().fit(states, self._meant(symbols))
        return fitted

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """As `fit`, for codes (pairs, 1) of the symbols of `action`, by its moves."""
        codes = np.arange(float(len(action.names)))
        moves = action.moves if isinstance(action, Symbols) and action.moves else None
        return self.fit(states, actions[:, 0], classes=codes, moves=moves)

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs; their symbols must be known ones."""
        check_is_fitted(self)
        added: Self = super().add_pairs(states, self._meant(np.ravel(actions)))
        return added

    def decide(self, states: Array) -> Array:
        """Codes of the symbols, their places in `classes_`, (queries, 1), for good states."""
        return self._codes(super().decide(states))

    def shown(self, pairs: Indices) -> Array | None:
        """Codes of the symbols of the kept `pairs` (k,), (k, 1); None where it keeps no pairs."""
        moves = super().shown(pairs)
        return None if moves is None else self._codes(moves)

    def predict(self, states: Any) -> AnyArray:
        """Symbols (queries,) for states (queries, n)."""
        check_is_fitted(self)
        codes = self.decide(checked_states(self, states))[:, 0]
        return np.asarray(self.classes_[codes.astype(np.int64)])

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file can hold of it."""
        own = {
            "moves": Stored(("actions", "components")),
            "classes": Stored(("actions",)),
        }
        return tuple({**_of_moves(layout), **own} for layout in super().layouts())

    def check_fitted(self) -> None:
        """Raise InvalidInputError where fitted arrays of the right shapes do not fit together."""
        super().check_fitted()
        if not np.array_equal(self.classes_, np.arange(len(self.classes_))):
            raise InvalidInputError("its symbols are not those of its action")

    def _codes(self, moves: Array) -> Array:
        """The symbols whose moves are nearest to `moves` (rows, components), (rows, 1)."""
        apart = ((moves[:, None] - self.moves_) ** 2).sum(axis=2)
        return np.asarray(apart.argmin(axis=1)[:, None], dtype=np.float64)

    def _meant(self, symbols: AnyArray) -> Array:
        """The moves that `symbols` (pairs,) stand for, (pairs, components)."""
        return np.asarray(self.moves_[checked_symbols(symbols, self.classes_)])


def _of_moves(layout: Layout) -> Layout:
    """`layout` with components of moves where actions have theirs."""
    return {
        name: replace(
            stored,
            shape=tuple("components" if axis == "actions" else axis for axis in stored.shape),
        )
        for name, stored in layout.items()
    }


class QuantizedSVRPolicy(Quantized, SVRPolicy):  # type: ignore[misc]
    """A smooth answer, quantised. Parameters and attributes are those of `SVRPolicy`, and above."""


class QuantizedKNNPolicy(Quantized, KNNPolicy):
    """A mean of neighbours, quantised. Parameters and attributes are those of `KNNPolicy`."""
