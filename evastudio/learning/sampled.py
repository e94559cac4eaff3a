"""Sampled k-NN: one of the things the demonstrator did here, as often as they did it."""

from __future__ import annotations

from typing import Any, ClassVar, Self

import numpy as np
from sklearn.utils.validation import check_is_fitted

from evastudio.learning.checking import checked_states, positive
from evastudio.learning.learner import SMALLEST, Layout, Stored
from evastudio.learning.neighbor_learner import Continuous
from evastudio.world.spaces import Array

BLOCK = 1_000_000
"""Pairs of neighbours compared at a time, to bound memory."""


class SampledKNNPolicy(Continuous):
    """Draws among the ways in which the `k` nearest pairs were answered.

    Neighbours whose actions can be linked by steps of at most `link` (in units of each
    component's range) are one way of acting, a mode. A neighbour is drawn, and the mean action of
    its mode is the decision; so a mode is chosen as often as it was shown, and conflicts need not
    be deleted (paper, section 5: probabilistic actions weighted by how often each is seen).

    Parameters
    ----------
    k : int
        How many pairs a decision is drawn from.
    link : float
        Share of the action's range up to which two actions are the same way of acting.

    Attributes
    ----------
    range_ : ndarray of shape (n_actions,), what each component spans; 1 where it never changes

    Raises InvalidInputError for no pairs, NaN, wrong shapes, `k` above the number of pairs or 200.
    """

    draws: ClassVar[bool] = True
    most: ClassVar[int | None] = 200

    def __init__(self, k: int = 7, link: float = 0.1) -> None:
        self.k = k
        self.link = link

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Remember the pairs: states (pairs, n), actions (pairs, m) or (pairs,)."""
        super().fit(states, actions)
        span = self.actions_.max(axis=0) - self.actions_.min(axis=0)
        self.range_ = np.where(span > 0.0, span, 1.0)
        return self

    def predict(self, states: Any, rng: np.random.Generator | None = None) -> Array:
        """Actions (queries, m) for states (queries, n), or (queries,) where fitted so.

        With `rng` they are drawn, without it each is the mode that was shown most often.
        """
        check_is_fitted(self)
        asked = checked_states(self, states)
        actions = self.decide(asked, None if rng is None else rng.random(len(asked)))
        return actions[:, 0] if self.flat_ else actions

    def decide(self, states: Array, draws: Array | None = None) -> Array:
        """Actions (queries, m); `draws` (queries,) in [0, 1) choose the modes.

        Without draws every decision is the mode that was shown most often.
        """
        answers = np.empty((len(states), self.actions_.shape[1]))
        size = max(1, BLOCK // int(self.k) ** 2)
        for start in range(0, len(states), size):
            rows = slice(start, start + size)
            answers[rows] = self._choose(states[rows], None if draws is None else draws[rows])
        return answers

    def _choose(self, states: Array, draws: Array | None) -> Array:
        _, pairs = self.nearest(states)
        actions = self.actions_[pairs]
        modes = self._modes(actions)
        if draws is None:
            chosen = modes.sum(axis=2).argmax(axis=1)
        else:
            chosen = np.minimum((draws * modes.shape[1]).astype(np.int64), modes.shape[1] - 1)
        members = np.take_along_axis(modes, chosen[:, None, None], axis=1)[:, 0, :]
        return np.asarray(
            (members[:, :, None] * actions).sum(axis=1) / members.sum(axis=1, keepdims=True)
        )

    def _modes(self, actions: Array) -> Array:
        """For each query which of its k neighbours act alike, (queries, k, k), 1 or 0."""
        scaled = actions / self.range_
        apart = np.zeros((*actions.shape[:2], actions.shape[1]))
        for column in range(actions.shape[2]):
            values = scaled[:, :, column]
            apart += (values[:, :, None] - values[:, None, :]) ** 2
        linked = (np.sqrt(apart) <= self.link).astype(np.float64)
        for _ in range(max(1, int(np.ceil(np.log2(max(2, actions.shape[1])))))):
            linked = (linked @ linked > 0.0).astype(np.float64)  # a link of links is a link
        return np.asarray(linked)

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        super().check_settings()
        positive(self, link=self.link)

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file holds of it."""
        (layout,) = super().layouts()
        return ({**layout, "range": Stored(("actions",), low=SMALLEST)},)
