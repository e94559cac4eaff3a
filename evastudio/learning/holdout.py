"""Holding out whole takes: how well a learner does on takes that it has not seen.

Frames of one take follow from each other, so a frame held out alone would have its twin among
the pairs learned from; only whole takes are held out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import clone, is_classifier

from evastudio.errors import InvalidInputError
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array

Mask = NDArray[np.bool_]
FOLDS = 5


@dataclass(frozen=True)
class HoldOut:
    """Errors on takes that were held out, each predicted by what the others taught."""

    error: float
    """Over all pairs, in the unit of `mistakes`: its square root for real actions."""
    by_take: Mapping[int, float]
    """The same for each take alone."""


def take_folds(takes: NDArray[np.int64], count: int = FOLDS) -> tuple[Mask, ...]:
    """Parts the takes into at most `count` groups of about as many pairs.

    Gives for each group which pairs are held out with it, shape (pairs,). The larger takes are
    dealt first, each to the smallest group so far, so equal takes give equal groups.
    Raises InvalidInputError for fewer than two takes.
    """
    names, sizes = np.unique(takes, return_counts=True)
    if len(names) < 2:
        raise InvalidInputError(
            "There is only one take, and what was learned can be tried only on a take that was "
            "held out. Record at least one more."
        )
    groups: list[list[int]] = [[] for _ in range(min(count, len(names)))]
    filled = np.zeros(len(groups), dtype=np.int64)
    for at in np.lexsort((names, -sizes)):
        smallest = int(filled.argmin())
        groups[smallest].append(int(names[at]))
        filled[smallest] += sizes[at]
    return tuple(np.isin(takes, group) for group in groups)


def some_takes(takes: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """Every take, or every second, third, ... so that they have about `most` pairs together.

    `takes` (pairs,). All of them where so few would be left that one tells little.
    """
    names = np.unique(takes)
    every = -(-len(takes) // most)
    return names[::every] if every > 1 and len(names) > 2 * every else names


def answers(
    learner: Any, states: Array, actions: Array, held: Mask, used: Mask | None = None
) -> Array:
    """What a `learner` fitted to the others says of the pairs of `held` (pairs,).

    states (pairs, n), actions (pairs, m) or (pairs,); of the others only those of `used` (pairs,)
    are learned from. `learner` itself stays as it was.
    """
    taught = ~held if used is None else ~held & used
    return np.asarray(clone(learner).fit(states[taught], actions[taught]).predict(states[held]))


def mistakes(
    learner: Any, states: Array, actions: Array, held: Mask, used: Mask | None = None
) -> Array:
    """Mistakes on the pairs of `held` (pairs,) of a `learner` fitted to the others; see `answers`.

    A mistake is the mean over the components of the squared difference, each in units of the
    component's variance over all pairs, so that a constant makes about 1; for symbols it is 1
    where the wrong one was given.
    """
    given = answers(learner, states, actions, held, used)
    return judged(
        given, actions[held], None if is_classifier(learner) else Scaling.of(actions).scale
    )


def judged(given: Array, wanted: Array, spread: Array | None) -> Array:
    """The mistake of each row of `given`, as `mistakes`; there is no `spread` of symbols."""
    if spread is None:
        return np.asarray((given != wanted).reshape(len(wanted), -1).any(axis=1), dtype=np.float64)
    apart = (given - wanted) / spread
    return np.asarray((apart.reshape(len(wanted), -1) ** 2).mean(axis=1))


def hold_out(
    learner: Any,
    states: Array,
    actions: Array,
    takes: NDArray[np.int64],
    *,
    used: Mask | None = None,
    count: int = FOLDS,
) -> HoldOut:
    """How far off `learner` is on takes it has not seen; see `mistakes` and `take_folds`."""
    wrong = np.empty(len(takes))
    for held in take_folds(takes, count):
        wrong[held] = mistakes(learner, states, actions, held, used)
    return summed_up(wrong, takes, is_classifier(learner))


def summed_up(wrong: Array, takes: NDArray[np.int64], symbols: bool) -> HoldOut:
    """Mistakes (pairs,) as one figure, and one for each take: a root mean square, or a share."""
    power = 1.0 if symbols else 0.5
    names, at, sizes = np.unique(takes, return_inverse=True, return_counts=True)
    by_take = (np.bincount(at, wrong) / sizes) ** power
    both = zip(names, by_take, strict=True)
    return HoldOut(float(wrong.mean() ** power), {int(take): float(error) for take, error in both})
