"""A small neural network: what most would reach for today to clone a behaviour."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils.validation import check_is_fitted

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import (
    checked_actions,
    checked_pairs,
    checked_states,
    positive,
)
from evastudio.learning.global_regressor import GlobalRegressor
from evastudio.learning.learner import SMALLEST, Indices, Layout, Stored
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array, Space

MOST = 512
"""More hidden units are no small network."""
BLOCK = 250_000
"""Hidden units worked out at a time, to bound memory."""


class MLPPolicy(GlobalRegressor):
    """One hidden layer of tanh units on standardised states, and a linear one out of it.

    Fitted by scikit-learn's `MLPRegressor` with L-BFGS on all pairs at once, actions divided by
    their observed half range. A network that was not fitted to pairs, but searched for
    (`pilots/pegasus.py`), is the same without pairs.

    Parameters
    ----------
    hidden : int
        Hidden units, up to 512.
    alpha : float
        Weight of the squared weights, over the number of pairs, against half the mean squared
        error.
    iterations : int
        L-BFGS stops after so many.
    seed : int
        Decides the weights that it begins with.

    Attributes
    ----------
    inner_ : ndarray of shape (n_states, hidden), inner_bias_ : ndarray of shape (hidden,)
    outer_ : ndarray of shape (hidden, n_actions), outer_bias_ : ndarray of shape (n_actions,), in
        units of the action
    offset_, scale_ : ndarray of shape (n_states,), the standardisation
    states_, actions_ : the pairs, standardised states and actions as given, where it has any

    Raises InvalidInputError for no pairs, NaN, wrong shapes, and settings that mean nothing.
    """

    def __init__(
        self, hidden: int = 32, alpha: float = 1.0, iterations: int = 300, seed: int = 0
    ) -> None:
        self.hidden = hidden
        self.alpha = alpha
        self.iterations = iterations
        self.seed = seed

    def fit(self, states: Any, actions: Any = None) -> Self:
        """Fit to states (pairs, n) and actions (pairs, m) or (pairs,)."""
        self.check_settings()
        states, actions = checked_pairs(self, states, actions)
        scaling = Scaling.of(states)
        self.offset_, self.scale_ = scaling.offset, scaling.scale
        return self._settle(scaling.apply(states), actions)

    def learn(
        self, states: Array, actions: Array, action: Space, progress: Callable[[float], None]
    ) -> Self:
        """As `fit`, for actions (pairs, m) in the space `action`; `progress` hears nothing."""
        return self.fit(states, actions)

    def _settle(self, states: Array, actions: Array) -> Self:
        """Fit to standardised `states`, which with their `actions` are kept."""
        from sklearn.neural_network import MLPRegressor  # loads slowly

        half = (actions.max(axis=0) - actions.min(axis=0)) / 2
        middle = (actions.max(axis=0) + actions.min(axis=0)) / 2
        moves = half > 0.0
        targets = (actions - middle) / np.where(moves, half, 1.0)
        network = MLPRegressor(
            hidden_layer_sizes=(int(self.hidden),),
            activation="tanh",
            solver="lbfgs",
            alpha=float(self.alpha),
            max_iter=int(self.iterations),
            max_fun=10 * int(self.iterations),
            random_state=int(self.seed),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # `iterations` is a budget
            network.fit(states, targets if targets.shape[1] > 1 else targets[:, 0])
        (self.inner_, outer), (self.inner_bias_, bias) = network.coefs_, network.intercepts_
        self.outer_ = outer * np.where(moves, half, 0.0)  # what never changes is given exactly
        self.outer_bias_ = bias * np.where(moves, half, 0.0) + middle
        self.states_, self.actions_ = states, actions
        return self.prepare()

    def add_pairs(self, states: Any, actions: Any) -> Self:
        """Learn more pairs: fitted anew to all of them, with the standardisation as it was.

        Raises InvalidInputError for a network that has no pairs.
        """
        self._need_pairs()
        scaled = self._scaling.apply(checked_states(self, states))
        more = checked_actions(actions, len(scaled), self.actions_.shape[1])
        return self._settle(
            np.concatenate([self.states_, scaled]), np.concatenate([self.actions_, more])
        )

    def remove_pairs(self, pairs: ArrayLike) -> Self:
        """Forget the pairs of these indices into `states_`; otherwise as `add_pairs`.

        Raises InvalidInputError for indices that are none, and where no pair would be left.
        """
        self._need_pairs()
        gone = self._forgotten(pairs)
        return self._settle(
            np.delete(self.states_, gone, axis=0), np.delete(self.actions_, gone, axis=0)
        )

    def _need_pairs(self) -> None:
        check_is_fitted(self)
        if not hasattr(self, "states_"):
            raise InvalidInputError(
                "This network was searched for, not shown: there are no demonstrations to add to "
                "or take from. Fit one to a session."
            )

    def prepare(self) -> Self:
        """Get ready to `decide` by the fitted arrays; `fit` and loading a file call it."""
        self._scaling = Scaling(self.offset_, self.scale_)
        self._columns = np.ascontiguousarray(self.outer_.T)
        self._index: NeighborIndex | None = None
        return self

    def decide(self, states: Array) -> Array:
        """Like `predict`, for states known to be good; the answer to one is that in any batch."""
        actions = np.empty((len(states), len(self._columns)))
        size = max(1, BLOCK // len(self.inner_bias_))
        for start in range(0, len(states), size):
            rows = slice(start, start + size)
            scaled = self._scaling.apply(states[rows])
            # Column by column, because BLAS rounds as the batch is large.
            sums = np.repeat(self.inner_bias_[None], len(scaled), axis=0)
            for component, weights in enumerate(self.inner_):
                sums += scaled[:, component, None] * weights
            np.tanh(sums, out=sums)
            for component, weights in enumerate(self._columns):
                actions[rows, component] = (sums * weights).sum(axis=1)
        return np.asarray(actions + self.outer_bias_)

    @property
    def kept(self) -> Indices:
        """Which of the pairs it was fitted to it still has: all of them, or it never had any."""
        return np.arange(len(self.states_) if hasattr(self, "states_") else 0)

    def _shown(self) -> Array:
        """What was shown, or of a network that was searched for, nothing."""
        return getattr(self, "states_", np.empty((0, len(self.offset_))))

    def _weights(self, distances: Array) -> Array:
        """All the same: a network cannot say what it decided from, only what was shown here."""
        return np.full(distances.shape, 1.0 / distances.shape[1])

    def check_settings(self) -> None:
        """Raise InvalidInputError for settings that mean nothing."""
        positive(self, alpha=self.alpha)
        for name, low, high in (
            ("hidden", 1, MOST),
            ("iterations", 1, 100_000),
            ("seed", 0, 2**32 - 1),
        ):
            value = getattr(self, name)
            whole = isinstance(value, (int, float, np.integer)) and value % 1 == 0
            if not whole or not low <= value <= high:
                raise InvalidInputError(
                    f"{name} is {value!r}; it must be a whole number from {low} to {high}."
                )

    def check_fitted(self) -> None:
        """Raise InvalidInputError where fitted arrays of the right shapes do not fit together."""
        if len(self.inner_bias_) != self.hidden:
            raise InvalidInputError(
                f"it should have {self.hidden} hidden units and has {len(self.inner_bias_)}"
            )
        if hasattr(self, "states_") and len(self.states_) == 0:
            raise InvalidInputError("it holds no pairs")

    def layouts(self) -> tuple[Layout, ...]:
        """What a policy file holds of it: with the pairs it was fitted to, or without any."""
        alone = {
            "inner": Stored(("states", "hidden")),
            "inner_bias": Stored(("hidden",)),
            "outer": Stored(("hidden", "actions")),
            "outer_bias": Stored(("actions",)),
            "offset": Stored(("states",)),
            "scale": Stored(("states",), low=SMALLEST),
        }
        pairs = {"states": Stored(("pairs", "states")), "actions": Stored(("pairs", "actions"))}
        return {**pairs, **alone}, alone
