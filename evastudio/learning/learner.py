"""What the rest of the studio asks of every learner, and what a policy file keeps of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.world.spaces import Array, Box, Space, Symbols

LARGEST = 1e60
"""No number of a policy is beyond this, so that no decision overflows."""
SMALLEST = 1.0 / LARGEST
"""Nor is a number that is divided by below this."""

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Stored:
    """One array of a fitted learner in a policy file."""

    shape: tuple[str, ...]
    """What each axis counts: 'states' and 'actions' their components (of symbols, 'actions' their
    number); another word any count, the same wherever it stands."""
    dtype: type[np.generic] = np.float64
    """How it is written; it must lose nothing by that."""
    low: float = -LARGEST
    """No number in it is below this."""


Layout = Mapping[str, Stored]
"""The fitted attributes that make a learner whole, without their underscore."""


@dataclass(frozen=True)
class Reasons:
    """Why a learner decided as it did."""

    pairs: Indices
    """The kept pairs nearest to each state, nearest first, shape (queries, k): indices of what
    `kept` lists, which for learners that keep every pair are those of the pairs fitted."""
    distances: Array
    """How far each of them is from the state asked about, standardised, shape (queries, k)."""
    weights: Array
    """How much each of them counted, shape (queries, k), rows summing to 1. An SVR weighs them by
    its kernel; all its other bases count too."""
    agreement: Array | None
    """1 where all their actions are the same, 0 where they differ as the pairs at large do: one
    minus the ratio of the weighted spread of their actions to that of all, not below 0;
    shape (queries,). None where the learner kept no demonstrated actions."""


class Spread:
    """How far actions are from their mean, on average and squared, as some come and go."""

    def __init__(self, actions: Array) -> None:
        """Of `actions` (pairs, m)."""
        self._about = actions.mean(axis=0)
        self._count = 0
        self._sum = np.zeros(actions.shape[1])
        self._squares = 0.0
        self.add(actions)

    def add(self, actions: Array, times: int = 1) -> None:
        """Count `actions` (any, m) too, or with -1 no more."""
        apart = actions - self._about
        self._count += times * len(actions)
        self._sum += times * apart.sum(axis=0)
        self._squares += times * float((apart**2).sum())

    @property
    def value(self) -> float:
        """The mean square."""
        mean = self._sum / self._count
        return max(0.0, self._squares / self._count - float(mean @ mean))


def agreement(actions: Array, weights: Array, among: Spread) -> Array:
    """How far neighbours agree, as `Reasons.agreement`, shape (queries,).

    `actions` (queries, k, m) are theirs, `weights` (queries, k), `among` the spread of all.
    """
    mean = (weights[:, :, None] * actions).sum(axis=1, keepdims=True)
    spread = (weights[:, :, None] * (actions - mean) ** 2).sum(axis=(1, 2))
    at_large = among.value
    share = np.sqrt(spread / at_large) if at_large > 0.0 else np.zeros(len(spread))
    return np.clip(1.0 - share, 0.0, 1.0)


class Learner(Protocol):
    """A function from states to actions that is fitted to pairs."""

    acts_in: ClassVar[type[Box] | type[Symbols]]
    """The kind of action it learns; symbols are learned as their codes."""
    draws: ClassVar[bool]
    """Whether it decides by chance."""
    n_features_in_: int
    flat_: bool

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """Fit to states (pairs, n) and actions (pairs, m) that lie in the space `action`.

        `progress` may hear the share done; what it raises stops the fit.
        """

    @property
    def decide(self) -> Callable[..., Array]:
        """Actions (queries, m) for good states (queries, n); of symbols their codes.

        Where it `draws`, (queries,) numbers from 0 to 1 may follow the states.
        """

    def explain(self, states: Any) -> Reasons:
        """Why it decides as it does for states (queries, n)."""

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs; the standardisation stays as it was fitted."""

    def remove_pairs(self, pairs: ArrayLike) -> Self:
        """Forget the pairs of these indices; those behind them move up."""

    def shown(self, pairs: Indices) -> Array | None:
        """The actions of the kept `pairs` (k,), as `decide` would give them, (k, m); None where
        it keeps none."""

    @property
    def kept(self) -> Indices:
        """Which of the pairs it was fitted to it still has."""

    def layouts(self) -> tuple[Layout, ...]:
        """What a file can hold of it, given its settings; the first that is at hand is written."""

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""

    def check_fitted(self) -> None:
        """Raise InvalidInputError where fitted arrays of the right shapes do not fit together."""

    def prepare(self) -> Self:
        """Get ready to decide by the fitted arrays."""

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Its settings."""

    def set_params(self, **settings: Any) -> Self:
        """Change settings."""
