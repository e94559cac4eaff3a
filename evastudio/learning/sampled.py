"""Sampled k-NN: one of the things the demonstrator did here, as often as they did it."""

from __future__ import annotations

import numpy as np

from evastudio.learning.checking import positive
from evastudio.learning.neighbor_learner import Continuous
from evastudio.world.spaces import Array


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

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and `k` above the number of pairs.
    """

    def __init__(self, k: int = 7, link: float = 0.1) -> None:
        self.k = k
        self.link = link

    def decide(self, states: Array, draws: Array | None = None) -> Array:
        """Actions (queries, m); `draws` (queries,) in [0, 1) choose the modes.

        Without draws every decision is the mode that was shown most often.
        """
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
        span = self.actions_.max(axis=0) - self.actions_.min(axis=0)
        scaled = actions / np.where(span > 0.0, span, 1.0)
        apart = np.sqrt(((scaled[:, :, None] - scaled[:, None]) ** 2).sum(axis=3))
        linked = (apart <= self.link).astype(np.float64)
        for _ in range(max(1, int(np.ceil(np.log2(max(2, actions.shape[1])))))):
            linked = (linked @ linked > 0.0).astype(np.float64)  # a link of links is a link
        return np.asarray(linked)

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        super().check_settings()
        positive(self, link=self.link)
