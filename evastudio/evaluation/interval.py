"""Intervals for shares: what 970 of 1,000 says about the rate behind it."""

from __future__ import annotations

import math

from evastudio.errors import InvalidInputError

Z_95 = 1.959963984540054
"""The standard normal quantile for a two-sided 95 % interval."""


def wilson_interval(successes: int, trials: int, z: float = Z_95) -> tuple[float, float]:
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
