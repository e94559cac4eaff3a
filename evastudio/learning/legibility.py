"""Whether decisions show in the state, told from few of them, while they are made.

A demonstrator who corrects early and minutely succeeds and teaches nothing: the decision is not in
the state. Every stretch of a few seconds is told by a plane through the others, and the mistakes
are compared with those of telling the mean. A plane, since so few pairs carry no more; and what is
told is all that one does in the time after a moment, since a hand answers late and taps keys.
"""

from __future__ import annotations

import numpy as np

from evastudio.learning.copying import repeating
from evastudio.learning.foretelling import foretold, plane_terms
from evastudio.world.spaces import Array

LEAST_FOR_EACH = 8
"""Pairs for each component of the state; of fewer nothing can be told."""
STRETCH_S = 4.0
"""What is nearer in time is of the same encounter, and told together."""
FOLDS = 5


def legibility(
    states: Array, answers: Array, before: Array, now: Array, dt_s: float
) -> float | None:
    """What telling by the state leaves of the mistakes of telling the mean.

    From about 1 on decisions do not show; the less, the better they do. None where there are too
    few, or always the same was done. `states` (pairs, n) are of moments every `dt_s` seconds,
    `answers` (pairs, m) what was done from each on, `before` and `now` (pairs, m) the single
    actions before and in it: what merely repeats those is left out (`learning.copying`).
    """
    shows = ~repeating(states, before, now)[0].any(axis=1)
    if len(states) < LEAST_FOR_EACH * max(shows.sum(), 1):
        return None
    part = np.arange(len(states)) // max(round(STRETCH_S / dt_s), 1) % FOLDS
    folds = tuple(part == fold for fold in range(FOLDS))
    unit = np.ones(answers.shape[1])
    constant = foretold(np.empty((len(answers), 0)), answers, folds, unit).mean()
    if constant < 1e-9:
        return None
    told = foretold(states[:, shows], answers, folds, unit, plane_terms, ridge=0.1)
    return float(told.mean() / constant)
