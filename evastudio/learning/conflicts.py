"""Conflict elimination: pairs that disagree with their neighbours (paper 3.1, figure 2, eq. 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted, column_or_1d

from evastudio.errors import InvalidInputError
from evastudio.learning.checking import checked_indices, checked_pairs, positive
from evastudio.learning.discoveries import far_fence, least_discovery
from evastudio.learning.neighbors import Indices, NeighborIndex
from evastudio.learning.plain_search import vector_medians
from evastudio.learning.scaling import Scaling
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array

BLOCK = 65_536
"""Pairs whose neighbours are looked at together, to bound memory."""
FALSE_SHARE = 0.35
"""Share of the pairs marked with "auto" that the usual spread alone may account for. At 0.3 fewer
of the mistakes of a human-like demonstrator are found where there are many, at 0.5 half of what is
marked of a careful one is no mistake (demonstration sets 1 to 3)."""
FENCE = 2.5
"""Quartile ranges above the upper quartile beyond which "auto" marks in any case; Tukey's inner and
outer fence are 1.5 and 3. Without it few mistakes are found where there are few; at 3 recall of a
human-like demonstrator's falls from 0.81 to 0.74."""
POOLED = 1.5
"""How much the spread everywhere counts beside that among the neighbours; 1 to 2 do as well."""
LEAST = 0.05
"""With "auto" no deviation below this share of the range is a conflict."""
RARITY = 0.75
"""With "auto" a symbol is a conflict where it is this much rarer than is usual for it."""


@dataclass(frozen=True)
class Conflict:
    """Why a pair was marked."""

    pair: int
    """Its number."""
    deviation: float
    """How far its action is from the median, as a share of the range; for symbols, how much
    rarer its own is among the neighbours than is usual for it, 0 to 1."""
    limit: float
    """The deviation beyond which it was marked."""
    neighbors: Indices
    """The pairs it was compared with, nearest first, shape (l,)."""
    median: AnyArray
    """Their median action, shape (m,); for symbols the most frequent one, shape (1,)."""


class ConflictEliminator(BaseEstimator):  # type: ignore[misc]
    """Leaves out every pair whose action is far from the median action of its neighbours.

    For each pair: find its `n_neighbors` nearest others by standardised state (the pair itself
    is not among them), take the vector median of their actions (eq. 3), and mark the pair where
    its own action is farther than the threshold from that median. All marked pairs are left out
    together, at the end. At the defaults this is the paper's rule: l = 5, eta = 10 % of the range.

    The paper has one range for all components. Here each component is divided by its own, and eta
    is compared with the Euclidean length of what is left, as in the paper: one component that is
    off by more than 10 % of its range is enough to be marked, and two that are off by 8 % each are
    too (11 % together). So the same threshold is stricter the more components an action has.

    With threshold "auto" every pair has a limit of its own. Its deviation is divided by what is
    usual: the median deviation of its neighbours, pooled with that of all pairs. So it takes more
    to stand out where the demonstration is never twice the same. Marked is what is then far out
    (`far_fence`), and, where conflicts are many, all from where on at most `FALSE_SHARE` of the
    pairs are there by the usual spread (`least_discovery`). This wants 15 to 35 neighbours.

    Mistakes last some moments, and pairs of the same moments lie together in state and confirm each
    other; told the `moments` of the pairs, those within `gap` of each other are no neighbours.

    With `symbols` an action is one of a finite set. Counted is the share of a pair's neighbours
    that have its symbol, and the deviation is how far that falls short of what is usual for this
    symbol (the median over its pairs): 0 where it does not, 1 where no neighbour has it. So a rare
    turn, which usually has few of its like around it, is no conflict where it has a few, and one of
    a symbol that never has any is none at all. "auto" is then a threshold of 0.75.

    Parameters
    ----------
    n_neighbors : int
        Called l in the paper, which uses 5.
    threshold : float or "auto"
        Called eta in the paper, which uses about 0.1; a share of the range.
    action_range : array-like of shape (n_actions,) or None
        High minus low of each component; the observed range where None.
    gap : int
        Pairs whose moments are no more than this apart are no neighbours; see `fit`.
    symbols : bool
        Whether actions are symbols: numbers or words without an order.

    Attributes (imbalanced-learn's sampler convention)
    ----------
    sample_indices_ : ndarray, the pairs that were kept
    conflict_mask_ : ndarray of bool, shape (n_pairs,), the pairs that were not
    deviations_ : ndarray of shape (n_pairs,), in units of the range
    limits_ : ndarray of shape (n_pairs,), the deviation beyond which each is a conflict
    threshold_ : float, the median of the limits
    range_ : ndarray of shape (n_actions,), as used; for symbols the
        usual share of each among the neighbours of its pairs
    classes_ : ndarray, the symbols, sorted, where there are any

    Raises InvalidInputError for NaN, wrong shapes, and too few pairs for `n_neighbors`.
    """

    def __init__(
        self,
        n_neighbors: int = 5,
        threshold: float | str = 0.1,
        action_range: ArrayLike | None = None,
        gap: int = 0,
        symbols: bool = False,
    ) -> None:
        self.n_neighbors = n_neighbors
        self.threshold = threshold
        self.action_range = action_range
        self.gap = gap
        self.symbols = symbols

    def fit(self, states: Any, actions: Any = None, moments: Any = None) -> Self:
        """Find the conflicts among states (pairs, n) and actions (pairs, m) or (pairs,).

        `moments` (pairs,) are whole numbers, one step apart from one decision to the next, far
        apart between takes; see `evastudio.demonstrations.pairs.Pairs.moments`.
        """
        for name in ("n_neighbors", "gap"):
            value = getattr(self, name)
            if isinstance(value, str) or value != int(value):
                raise InvalidInputError(
                    f"{name} is {value!r}; it must be a whole number from "
                    f"{1 if name == 'n_neighbors' else 0} on."
                )
        positive(self, n_neighbors=self.n_neighbors)
        if self.threshold != "auto":
            positive(self, threshold=self.threshold)  # type: ignore[arg-type]
        if self.symbols and actions is not None:
            self.classes_, actions = np.unique(column_or_1d(actions), return_inverse=True)
        states, actions = checked_pairs(self, states, actions)
        self._moments = None if moments is None else np.asarray(moments, dtype=np.int64)
        self._actions = actions
        self._index = NeighborIndex(Scaling.of(states).apply(states))
        if self.symbols:
            self._judge_symbols()
        else:
            self._judge_actions()
        self.threshold_ = float(np.median(self.limits_))
        self.conflict_mask_ = self.deviations_ > self.limits_
        self.sample_indices_ = np.flatnonzero(~self.conflict_mask_)
        return self

    def fit_resample(self, states: Any, actions: Any, moments: Any = None) -> tuple[Any, Any]:
        """The states and actions without the conflicts, in their order."""
        self.fit(states, actions, moments)
        return np.asarray(states)[self.sample_indices_], np.asarray(actions)[self.sample_indices_]

    def explain(self, pairs: ArrayLike | None = None) -> tuple[Conflict, ...]:
        """The report on those `pairs`, by number, or on all that were marked.

        Worked out when asked for. Raises InvalidInputError for pairs that there are not.
        """
        check_is_fitted(self)
        chosen = np.flatnonzero(self.conflict_mask_) if pairs is None else pairs
        numbers = checked_indices(chosen, len(self.conflict_mask_))
        neighbors = self.neighbors()[numbers]
        span = None if self.symbols else self.range_
        medians: AnyArray = usual_actions(self._actions[neighbors], span)
        if self.symbols:
            medians = self.classes_[medians.astype(np.int64)]
        return tuple(
            Conflict(
                int(pair),
                float(self.deviations_[pair]),
                float(self.limits_[pair]),
                neighbors[row],
                medians[row],
            )
            for row, pair in enumerate(numbers)
        )

    def neighbors(self) -> Indices:
        """The pairs that each is compared with, nearest first, (pairs, l). Worked out anew."""
        check_is_fitted(self)
        return self._nearest()

    def _nearest(self) -> Indices:
        return self._index.nearest_others(int(self.n_neighbors), self._moments, int(self.gap))

    def _judge_actions(self) -> None:
        self.range_ = self._range(self._actions)
        self.deviations_ = self._index.median_deviations(
            self._actions / self.range_, int(self.n_neighbors), self._moments, int(self.gap)
        )
        if self.threshold != "auto":
            self.limits_ = np.full(len(self.deviations_), float(self.threshold))
            return
        usual = np.empty_like(self.deviations_)
        neighbors = self._nearest()
        for at in range(0, len(usual), BLOCK):
            rows = slice(at, at + BLOCK)
            usual[rows] = np.median(self.deviations_[neighbors[rows]], axis=1)
        usual = np.maximum(np.hypot(usual, POOLED * np.median(usual)), 1e-9)
        scores = self.deviations_ / usual
        cut = min(least_discovery(scores, FALSE_SHARE), far_fence(scores, FENCE))
        self.limits_ = np.maximum(LEAST, (1.0 - 1e-9) * cut * usual)  # the pair at the cut is out

    def _judge_symbols(self) -> None:
        codes = self._actions[:, 0].astype(np.int64)
        neighbors = self._nearest()
        alike = np.empty(len(codes))
        for at in range(0, len(codes), BLOCK):
            rows = slice(at, at + BLOCK)
            alike[rows] = (codes[neighbors[rows]] == codes[rows, None]).mean(axis=1)
        usual = np.array([np.median(alike[codes == code]) for code in range(len(self.classes_))])
        self.range_ = np.maximum(usual, 1e-9)
        self.deviations_ = np.where(
            usual[codes] > 0.0, np.maximum(0.0, 1.0 - alike / self.range_[codes]), 0.0
        )
        limit = RARITY if self.threshold == "auto" else float(self.threshold)
        self.limits_ = np.full(len(codes), limit)

    def _range(self, actions: Array) -> Array:
        if self.action_range is None:
            span = actions.max(axis=0) - actions.min(axis=0)
            return np.where(span > 0, span, 1.0)
        given = np.asarray(self.action_range, dtype=np.float64).reshape(-1)
        if given.shape != (actions.shape[1],) or not (np.isfinite(given) & (given > 0)).all():
            raise InvalidInputError(
                f"action_range is {self.action_range!r}; it must be {actions.shape[1]} numbers "
                "above 0, one for each component of the action."
            )
        return given


def usual_actions(actions: Array, span: Array | None) -> Array:
    """The vector median (rows, m) of each row's `actions` (rows, l, m), each component by `span`.

    Without a span actions are codes of symbols, and it is the most frequent one.
    """
    if span is not None:
        return vector_medians(actions / span) * span
    codes = actions[:, :, 0].astype(np.int64)
    most = [np.bincount(row).argmax() for row in codes]
    return np.array(most, dtype=np.float64)[:, None]
