"""Telling what is out of the ordinary from the far end of the ordinary."""

from __future__ import annotations

import numpy as np

from evastudio.world.spaces import Array


def least_discovery(scores: Array, false_share: float) -> float:
    """The score from which on at most `false_share` of the `scores` (n,) are ordinary ones.

    Ordinary scores are taken to thin out exponentially beyond their upper quartile, at the rate at
    which they do between the median and there; so up to a quarter of the scores may be out of the
    ordinary. Of those from some score on, the share that is ordinary is then the number expected
    over the number found, and the least score is chosen that keeps it within `false_share`
    (Benjamini and Hochberg 1995, with a null fitted to the data: Efron 2004). Infinite where no
    score does: ordinary data give none.
    """
    middle, upper = np.quantile(scores, [0.5, 0.75])
    rate = np.log(2.0) / max(upper - middle, 1e-9)
    ordered = np.sort(scores)[::-1]
    ordered = ordered[ordered > upper]
    expected = 0.25 * len(scores) * np.exp(-(ordered - upper) * rate)
    within = np.flatnonzero(expected <= false_share * np.arange(1, len(ordered) + 1))
    return float(ordered[within[-1]]) if len(within) else float("inf")


def far_fence(scores: Array, ranges: float) -> float:
    """So many quartile `ranges` above the upper quartile of the `scores` (n,).

    Tukey, "Exploratory Data Analysis", 1977: beyond 1.5 is outside, beyond 3 far out.
    """
    lower, upper = np.quantile(scores, [0.25, 0.75])
    return float(upper + ranges * (upper - lower))
