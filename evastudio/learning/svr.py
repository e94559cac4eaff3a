"""Epsilon-SVR with a Gaussian kernel, one function for each component of the action (paper 3.2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import clone
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.bumps import Bumps
from evastudio.learning.checking import (
    checked_actions,
    checked_pairs,
    checked_states,
    positive,
)
from evastudio.learning.compact import compact_form
from evastudio.learning.dual import solve_dual
from evastudio.learning.global_regressor import GlobalRegressor
from evastudio.learning.learner import SMALLEST, Indices, Layout, Stored
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array, Space

MOST_BASES = 2048
"""More bases are no compact form, and choosing them would take gigabytes."""
PAIRS = ("states", "actions", "duals", "middle", "half")
"""What a compact form goes without."""


class SVRPolicy(GlobalRegressor):
    """Smooth, compact policy: a sum of Gaussian bumps on standardised states.

    Each component of the action is divided by its observed half range and fitted on its own; the
    support vectors of all are then joined, so that one kernel matrix answers for all components.
    Both the solver and the decisions are compiled by numba at first use.

    Parameters
    ----------
    C : float
        How hard deviations beyond `epsilon` are punished.
    epsilon : float
        Deviation that costs nothing, as a share of half the action's range.
    gamma : float
        Narrowness of the bumps: exp(-gamma * squared standardised distance). In a good frame
        the kernel wants to be broad: 0.05 crosses far fewer fields than 0.01.
    cache_mb : float
        Memory for the solver's kernel cache; where the rows do not fit, they are computed again.
    bases : int or None
        With a number, the fitted function is then given a compact form: that many bumps at most,
        chosen among all pairs and refitted to it. 256 take 7 KB in a policy file at 8 state and 2
        action components; hold-out error stays within 3 % of the whole one's, often below it.

    Attributes
    ----------
    support_ : ndarray of shape (n_support,), the pairs that became support vectors, or bases
    support_vectors_ : ndarray of shape (n_support, n_states), standardised
    coefficients_ : ndarray of shape (n_support, n_actions), in units of the action
    intercept_ : ndarray of shape (n_actions,)
    offset_, scale_ : ndarray of shape (n_states,), the standardisation
    states_, actions_ : the pairs, standardised states and actions as given; not of a compact form
    duals_ : ndarray of shape (n_pairs, n_actions), their weights in [-C, C], mostly zero
    middle_, half_ : ndarray of shape (n_actions,), the range of the actions fitted to

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and settings not above zero.
    """

    def __init__(
        self,
        C: float = 30.0,  # noqa: N803 - the literature's name
        epsilon: float = 0.2,
        gamma: float = 0.01,
        cache_mb: float = 400.0,
        bases: int | None = None,
    ) -> None:
        self.C = C
        self.epsilon = epsilon
        self.gamma = gamma
        self.cache_mb = cache_mb
        self.bases = bases

    def fit(
        self, states: Any, actions: Any = None, *, progress: Callable[[float], None] | None = None
    ) -> Self:
        """Fit to states (pairs, n) and actions (pairs, m) or (pairs,).

        `progress` hears the share done many times a second; what it raises stops the fit.
        """
        self.check_settings()
        states, actions = checked_pairs(self, states, actions)
        scaling = Scaling.of(states)
        self.offset_, self.scale_ = scaling.offset, scaling.scale
        half = (actions.max(axis=0) - actions.min(axis=0)) / 2
        self.half_ = np.where(half > 0, half, 1.0)
        self.middle_ = (actions.max(axis=0) + actions.min(axis=0)) / 2
        self._settle(scaling.apply(states), actions, None, progress)
        self.prepare()
        if self.bases is not None:
            self._take_compact_form(states, self.bases, self._bumps.answer(states))
            self.prepare()
        return self

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """As `fit`, for actions (pairs, m) in the space `action`."""
        return self.fit(states, actions, progress=progress)

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs: states (more, n), actions (more, m), or (more,) where fitted so.

        The solver goes on from where it was, and ends where a fit to all the pairs would with the
        same standardisation and range of the actions. Raises InvalidInputError for a policy that
        keeps no pairs: one of compact form, or read from a file of format 2.
        """
        self._need_pairs()
        scaled = self._scaling.apply(checked_states(self, states))
        more = checked_actions(actions, len(scaled), self.actions_.shape[1])
        start = np.concatenate([self.duals_, np.zeros(more.shape)])
        self._settle(
            np.concatenate([self.states_, scaled]), np.concatenate([self.actions_, more]), start
        )
        return self.prepare()

    def remove_pairs(self, pairs: ArrayLike) -> Self:
        """Forget the pairs of these indices into `states_`; otherwise as `add_pairs`.

        Raises InvalidInputError for indices that are none, and where no pair would be left.
        """
        self._need_pairs()
        gone = self._forgotten(pairs)
        states, actions, start = (
            np.delete(array, gone, axis=0) for array in (self.states_, self.actions_, self.duals_)
        )
        self._settle(states, actions, _balanced(start, float(self.C)))
        return self.prepare()

    def _need_pairs(self) -> None:
        check_is_fitted(self)
        if not hasattr(self, "duals_"):
            raise InvalidInputError(
                "This policy keeps no demonstrations to add to or take from: it has a compact "
                "form, or an older file. Fit it again from its session, all bases kept."
            )

    def _settle(
        self,
        states: Array,
        actions: Array,
        start: Array | None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Fit to standardised `states`; `start` are weights to begin with."""
        solution = solve_dual(
            states,
            (actions - self.middle_) / self.half_,
            C=float(self.C),
            epsilon=float(self.epsilon),
            gamma=float(self.gamma),
            megabytes=float(self.cache_mb),
            start=start,
            watch=progress,
        )
        self.states_, self.actions_, self.duals_ = states, actions, solution.weights
        self.intercept_ = solution.intercepts * self.half_ + self.middle_

    def compact(self, states: Any, bases: int = 256) -> SVRPolicy:
        """This fitted policy with at most `bases` bumps, chosen among and refitted on `states`.

        `states` (pairs, n) are best those it was fitted to: explanations name rows of them.
        """
        check_is_fitted(self)
        smaller: SVRPolicy = clone(self).set_params(bases=bases)
        smaller.check_settings()
        states = checked_states(self, states)
        for name in ("n_features_in_", "feature_names_in_", "flat_"):
            if hasattr(self, name):
                setattr(smaller, name, getattr(self, name))
        smaller.offset_, smaller.scale_ = self.offset_, self.scale_
        smaller._take_compact_form(states, bases, self._bumps.answer(states))
        return smaller.prepare()

    def _take_compact_form(self, states: Array, bases: int, answers: Array) -> None:
        scaled = Scaling(self.offset_, self.scale_).apply(states)
        form = compact_form(scaled, answers, float(self.gamma), int(bases))
        self.support_, self.support_vectors_ = form.chosen, form.vectors
        self.coefficients_, self.intercept_ = form.weights, form.intercept
        for name in PAIRS:
            self.__dict__.pop(name + "_", None)

    def prepare(self) -> Self:
        """Get ready to `decide` by the fitted arrays; `fit` and loading a file call it."""
        if hasattr(self, "duals_"):
            self.support_ = np.flatnonzero((self.duals_ != 0.0).any(axis=1))
            self.support_vectors_ = self.states_[self.support_]
            self.coefficients_ = self.duals_[self.support_] * self.half_
        self._scaling = Scaling(self.offset_, self.scale_)
        self._bumps = Bumps(
            self.support_vectors_,
            self.coefficients_,
            float(self.gamma),
            self.intercept_,
            self._scaling,
        )
        self._index: NeighborIndex | None = None
        return self

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        return self._bumps.answer(states)

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        positive(self, C=self.C, epsilon=self.epsilon, gamma=self.gamma, cache_mb=self.cache_mb)
        bases = self.bases
        numeric = isinstance(bases, (int, float, np.number))
        if bases is not None and (not numeric or bases % 1 != 0 or not 1 <= bases <= MOST_BASES):
            raise InvalidInputError(
                f"bases is {bases!r}; it must be a whole number from 1 to {MOST_BASES}, or None "
                "for all."
            )

    @property
    def kept(self) -> Indices:
        """Which of the pairs it was fitted to it still has: all, or those that became bases.

        Of a compact form read from a file only how many those are is known.
        """
        if hasattr(self, "duals_"):
            return np.arange(len(self.states_))
        return self.support_ if hasattr(self, "support_") else np.arange(len(self.coefficients_))

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file can hold of it: its pairs, or of a compact form the bases alone.

        Until format 3 files held `support` and no pairs.
        """
        scaling = {
            "intercept": Stored(("actions",)),
            "offset": Stored(("states",)),
            "scale": Stored(("states",), low=SMALLEST),
        }
        if self.bases is not None:
            compact = {**_bases(np.float16, np.float32), **scaling}
            return compact, {"support": Stored(("bases",), np.int32, low=0.0), **compact}
        pairs = {
            "states": Stored(("pairs", "states")),
            "actions": Stored(("pairs", "actions")),
            "duals": Stored(("pairs", "actions")),
            "middle": Stored(("actions",)),
            "half": Stored(("actions",), low=SMALLEST),
        }
        support = Stored(("bases",), np.int64, low=0.0)
        alone = {"support": support, **_bases(np.float64, np.float64), **scaling}
        return {**pairs, **scaling}, alone

    def check_fitted(self) -> None:
        """Fitted arrays of the right shapes fit together."""

    def _shown(self) -> Array:
        """The pairs fitted to, or of a compact form, which keeps none, its bases.

        These stand where pairs were, spread over the states, so the nearest pair may be nearer
        than the nearest base, and what was demonstrated there is not known.
        """
        return self.states_ if hasattr(self, "duals_") else self.support_vectors_

    def _weights(self, distances: Array) -> Array:
        """Kernel values: an SVR decides from all its bases at once, the nearer the more."""
        kernel = np.exp(-float(self.gamma) * (distances**2 - distances[:, :1] ** 2))
        return np.asarray(kernel / kernel.sum(axis=1, keepdims=True))


def _bases(vector: type[np.generic], weight: type[np.generic]) -> dict[str, Stored]:
    return {
        "support_vectors": Stored(("bases", "states"), vector),
        "coefficients": Stored(("bases", "actions"), weight),
    }


def _balanced(duals: Array, C: float) -> Array:  # noqa: N803 - the literature's name
    """`duals` (pairs, m) in the box, with what is missing for sums of zero laid on some of them."""
    duals = np.clip(duals, -C, C)
    for column in duals.T:
        missing = -column.sum()
        room = (C - column) if missing > 0.0 else (column + C)
        room = (
            np.where(column != 0.0, room, 0.0) if room[column != 0.0].sum() > abs(missing) else room
        )
        total = room.sum()
        if total > 0.0:
            column += missing * room / total
    return duals
