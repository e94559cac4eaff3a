"""Intervals: what 970 of 1,000 says about the rate behind it, and worlds about their mean."""

from __future__ import annotations

import math

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.world.spaces import Array

Interval = tuple[float, float]
"""From, to."""

Z_95 = 1.959963984540054
"""The standard normal quantile for a two-sided 95 % interval."""
RESAMPLES = 2000
AT_ONCE = 500_000
"""Figures drawn in one go."""
LUCK = 20260
"""The bootstrap's seed: the same figures give the same interval."""


def wilson_interval(successes: int, trials: int, z: float = Z_95) -> Interval:
    """The Wilson score interval of a rate, 95 % unless `z` says otherwise.

    Wilson, "Probable inference, the law of succession, and statistical inference", 1927. It
    stays within 0 and 1 and is honest at 0 and 100 %. Raises InvalidInputError for counts that
    cannot be.
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise InvalidInputError(
            f"{successes} successes of {trials} trials cannot be; trials start at 1."
        )
    rate = successes / trials
    spread = z * math.sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    middle = rate + z * z / (2 * trials)
    whole = 1 + z * z / trials
    low = 0.0 if successes == 0 else (middle - spread) / whole
    high = 1.0 if successes == trials else (middle + spread) / whole
    return low, high


def mean_interval(figures: Array) -> Interval:
    """The 95 % bootstrap percentile interval of the mean of `figures` (worlds,).

    B. Efron, R. Tibshirani, "An introduction to the bootstrap", 1993, chapter 13. Raises
    InvalidInputError for no figures.
    """
    if len(figures) == 0:
        raise InvalidInputError("There are no figures to average; at least one world is needed.")
    rng = np.random.default_rng(LUCK)
    count = len(figures)
    rows = max(1, AT_ONCE // count)
    means = np.concatenate(
        [
            figures[rng.integers(count, size=(min(rows, RESAMPLES - first), count))].mean(axis=1)
            for first in range(0, RESAMPLES, rows)
        ]
    )
    low, high = np.quantile(means, (0.025, 0.975))
    return float(low), float(high)
