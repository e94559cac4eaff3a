"""Where is the state space thin? Moments of one take that no other take comes near."""

from __future__ import annotations

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.finding import Finding, plain
from evastudio.learning.holdout import Mask
from evastudio.world.spaces import Array, Box

FAR = 4.0
"""A moment is alone where the nearest moment of other takes is this many times farther than is
usual; in 7,200 pairs of the asteroid field about 1 in 200 is."""
THIN = 0.03
"""Share of moments alone from which there is something to show: a bell-shaped cloud of a few
thousand moments in three dimensions leaves 2 % of them alone in its tails."""
PARTS = 20


def find_thin(pairs: Pairs, nearest: Array, state: Box) -> Finding:
    """Where takes go that the others do not.

    `nearest` (pairs,) are the distances to the nearest pair of other takes. The measure is the
    share of moments that are alone; the details name the range of the component where most are.
    """
    usual = float(np.median(nearest))
    alone = nearest > FAR * usual
    share = float(alone.mean())
    if share < THIN or usual == 0.0:
        return Finding("thin", False, share, "Your takes cover much the same situations.")
    column, low, high, inside = max(
        (_range(pairs.states[:, at], alone, at) for at in range(state.size)),
        key=lambda found: found[3],
    )
    name, unit = state.names[column], state.fields[column].unit
    measure = "" if unit in ("", "1") else f" {unit}"
    sentence = (
        f"{100 * share:.0f} % of the moments are unlike anything in your other takes, most of all "
        f"where “{plain(name)}” is {low:.3g} to {high:.3g}{measure}. Show more of that."
    )
    details = {"component": name, "low": low, "high": high, "share_inside": inside}
    return Finding("thin", True, share, sentence, details)


def _range(values: Array, alone: Mask, column: int) -> tuple[int, float, float, float]:
    """The stretch of `values` (pairs,) around the part where most are alone, and how many are.

    Parts are equally wide between the 1 and 99 % quantiles, the outer ones open; a part counts
    where it holds at least 1 % of all alone moments.
    """
    low, high = np.quantile(values, (0.01, 0.99))
    if not low < high:
        return column, float(low), float(high), 0.0
    part = np.clip((values - low) / (high - low) * PARTS, 0, PARTS - 1).astype(np.int64)
    there = np.bincount(part, minlength=PARTS)
    lonely = np.bincount(part[alone], minlength=PARTS)
    share = np.where(lonely >= 0.01 * alone.sum(), lonely / np.maximum(there, 1), 0.0)
    first = last = int(share.argmax())
    while first > 0 and share[first - 1] >= share.max() / 2:
        first -= 1
    while last < PARTS - 1 and share[last + 1] >= share.max() / 2:
        last += 1
    inside = (part >= first) & (part <= last)
    found = values[inside]
    return column, float(found.min()), float(found.max()), float(alone[inside].mean())
