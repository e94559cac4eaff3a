"""What the state does not explain: decisions that are not in it, and moments it cannot tell apart.

Both are read off takes held out. Where no learner does better than a constant although each
action follows from the last, the decisions are hidden: they were made from something else, or so
early and so small that the state does not show them. Where the state explains a part, and what is
left keeps its sign for half a second, like states were answered differently at different moments:
something is missing from the state. Mistakes are short and few, and the largest mistakes are set
aside first; what noise and haste leave does not last.
"""

from __future__ import annotations

import numpy as np

from evastudio.demonstrations.pairs import Pairs, answered_pairs
from evastudio.learning.finding import Finding
from evastudio.learning.foretelling import foretold
from evastudio.learning.holdout import Mask, take_folds
from evastudio.world.spaces import Array

BLIND = 0.95
"""Decisions are hidden where the error is at least this share of a constant's; the asteroid
field's is 0.5 to 0.8."""
ORDERLY = 0.75
"""And where the action before foretells them with at most this share of it: chance would not."""
LASTS_S = 0.5
ALIKE = 0.3
"""Something is missing where what is unexplained now and half a second later agree by this
correlation; in the asteroid field it is at most 0.11."""
MUCH = 0.25
"""And where that is at least this share of a constant's error."""
WORST = 0.05
"""Share of the largest mistakes that is set aside, as conflicts."""


def find_hidden(
    pairs: Pairs, left: Array, constant: float, folds: tuple[Mask, ...], unit: Array
) -> Finding:
    """Whether the decisions show in the state at all.

    `left` (pairs, m) is what neighbours in state leave unexplained, in units of `unit` (m,), and
    `constant` a constant's error. The measure is the least error as a share of that.
    """
    curve = float(foretold(pairs.states, pairs.actions, folds, unit).mean())
    share = min(curve, float((left**2).mean())) / max(constant, 1e-12)
    rows = np.flatnonzero((np.diff(pairs.takes) == 0) & (np.diff(pairs.steps) == 1))
    order = 1.0
    if len(np.unique(pairs.takes[rows])) > 1:
        after = foretold(
            pairs.actions[rows], pairs.actions[rows + 1], take_folds(pairs.takes[rows]), unit
        )
        order = float(after.mean()) / max(constant, 1e-12)
    details = {"from_last_action": order}
    if share < BLIND or order > ORDERLY or constant < 1e-12:
        return Finding("hidden", False, share, "Your decisions show in the state.", details)
    sentence = (
        "What you did cannot be told from what the character sees: react later and more visibly, "
        "keep a wider berth, or choose another perception."
    )
    return Finding("hidden", True, share, sentence, details)


def find_ambiguous(pairs: Pairs, left: Array, constant: float, dt_s: float) -> Finding:
    """Whether like states are answered differently at different moments.

    `left` and `constant` as above. The measure is the correlation of what is unexplained with
    what is half a second later.
    """
    size = (left**2).mean(axis=1)
    usual = size <= np.quantile(size, 1.0 - WORST)
    share = float(size[usual].mean()) / max(constant, 1e-12)
    later = max(round(LASTS_S / dt_s), 1)
    kept = np.where(usual[:, None], left, np.nan)
    apart = answered_pairs(Pairs(kept, kept, pairs.takes, pairs.steps), later)
    both = np.isfinite(apart.states).all(axis=1) & np.isfinite(apart.actions).all(axis=1)
    before, now = apart.states[both], apart.actions[both]
    scale = float(np.sqrt((before**2).sum() * (now**2).sum()))
    alike = float((before * now).sum()) / scale if scale > 1e-12 else 0.0
    details = {"share_unexplained": share}
    if alike < ALIKE or share < MUCH:
        sentence = "Like situations are answered alike."
        return Finding("ambiguous", False, alike, sentence, details)
    sentence = (
        "Situations that look the same to the character were answered differently at different "
        "times, for a while each: something you went by is missing from what it sees. Choose "
        "another perception, or keep to one way of doing it."
    )
    return Finding("ambiguous", True, alike, sentence, details)


def constant_error(actions: Array, folds: tuple[Mask, ...], unit: Array) -> float:
    """Squared error of the other takes' mean action."""
    return float(foretold(np.empty((len(actions), 0)), actions, folds, unit).mean())
