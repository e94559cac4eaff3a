"""Diagnostics: what would keep a policy from learning these pairs, and what to do about it."""

from __future__ import annotations

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.copying import find_copies
from evastudio.learning.coverage import find_thin
from evastudio.learning.finding import Finding
from evastudio.learning.holdout import Mask, some_takes, take_folds
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.learning.unexplained import constant_error, find_ambiguous, find_hidden
from evastudio.world.spaces import Array, Box

NEIGHBORS = 15
MOST_PAIRS = 30_000
"""Of more pairs, every second, third, ... take is looked at."""


def diagnose(pairs: Pairs, state: Box, dt_s: float) -> list[Finding]:
    """Every finding about `pairs`, worst first among those where something was found.

    The reaction delay should have been taken out. `state` describes the states. With fewer than
    two takes only copies can be looked for.
    """
    names = np.unique(pairs.takes)
    pairs = pairs.keep(np.isin(pairs.takes, some_takes(pairs.takes, MOST_PAIRS)))
    copies = find_copies(pairs, state.names)
    if len(names) < 2:
        return [copies]
    folds = take_folds(pairs.takes)
    unit = Scaling.of(pairs.actions).scale
    constant = constant_error(pairs.actions, folds, unit)
    nearest, left = _of_other_takes(pairs, folds, unit)
    hidden = find_hidden(pairs, left, constant, folds, unit)
    ambiguous = find_ambiguous(pairs, left, constant, dt_s)
    if hidden.found and ambiguous.found:  # where nothing is visible, like states mean nothing
        ambiguous = Finding("ambiguous", False, ambiguous.measure, "See above.", ambiguous.details)
    findings = [copies, hidden, ambiguous, find_thin(pairs, nearest, state)]
    return sorted(findings, key=lambda finding: not finding.found)


def _of_other_takes(pairs: Pairs, folds: tuple[Mask, ...], unit: Array) -> tuple[Array, Array]:
    """For each pair how far the nearest of other folds is, and what those nearest do not explain.

    Shapes (pairs,) and (pairs, m), the latter in units of `unit` (m,).
    """
    scaled = Scaling.of(pairs.states).apply(pairs.states)
    nearest = np.empty(len(pairs))
    left = np.empty_like(pairs.actions)
    for held in folds:
        taught = ~held
        count = min(NEIGHBORS, int(taught.sum()))
        distances, others = NeighborIndex(scaled[taught]).nearest(scaled[held], count)
        nearest[held] = distances[:, 0]
        left[held] = (pairs.actions[held] - pairs.actions[taught][others].mean(axis=1)) / unit
    return nearest, left
