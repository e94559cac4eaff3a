"""Two pilots on the same worlds, compared world by world.

Pairing takes out what both share, the luck of the world, so that small differences show in few
worlds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from evastudio.errors import InvalidInputError
from evastudio.evaluation.interval import Interval, mean_interval, wilson_interval
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Difference:
    """The first pilot less the second."""

    difference: float
    """Of the rates, or of the means over the worlds that both have a figure for."""
    interval: Interval
    """95 %."""
    p: float
    """How often chance alone would differ as much, were there no difference."""
    effect: float
    """-1 to 1. For rates: of the worlds where just one succeeded, the share won less the share
    lost. For figures: the matched-pairs rank-biserial correlation (D. S. Kerby, "The simple
    difference formula", 2014)."""
    worlds: int
    """Worlds that the comparison rests on."""
    test: str

    def to_json(self) -> dict[str, Any]:
        return {
            "difference": self.difference,
            "interval": list(self.interval),
            "p": self.p,
            "effect": self.effect,
            "worlds": self.worlds,
            "test": self.test,
        }


def compare_rates(ours: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> Difference:
    """Successes in the same worlds, shapes (worlds,): McNemar's exact test.

    The interval is R. G. Newcombe's, "Improved confidence intervals for the difference between
    binomial proportions based on paired data", 1998, method 10. Raises InvalidInputError for no
    worlds or different ones.
    """
    _same(ours, theirs)
    both = int((ours & theirs).sum())
    won, lost = int((ours & ~theirs).sum()), int((~ours & theirs).sum())
    count = len(ours)
    neither = count - both - won - lost
    first, second = (both + won) / count, (both + lost) / count
    low1, high1 = wilson_interval(both + won, count)
    low2, high2 = wilson_interval(both + lost, count)
    product = (both + won) * (lost + neither) * (both + lost) * (won + neither)
    cross = float(both * neither - won * lost)
    if cross > 0:  # the source's correction for continuity
        cross = max(cross - count / 2, 0.0)
    phi = cross / math.sqrt(product) if product else 0.0
    down = (first - low1) ** 2 - 2 * phi * (first - low1) * (high2 - second)
    up = (high1 - first) ** 2 - 2 * phi * (high1 - first) * (second - low2)
    difference = first - second
    return Difference(
        difference=difference,
        interval=(
            difference - math.sqrt(down + (high2 - second) ** 2),
            difference + math.sqrt(up + (second - low2) ** 2),
        ),
        p=float(stats.binomtest(won, won + lost).pvalue) if won + lost else 1.0,
        effect=(won - lost) / (won + lost) if won + lost else 0.0,
        worlds=count,
        test="McNemar, exact",
    )


def compare_figures(ours: Array, theirs: Array) -> Difference | None:
    """Figures of the same worlds, shapes (worlds,): Wilcoxon's signed-rank test.

    Worlds where either has none (NaN or infinite) are left out; None where fewer than two are
    left. Raises InvalidInputError for no worlds or different ones.
    """
    _same(ours, theirs)
    both = np.isfinite(ours) & np.isfinite(theirs)
    if both.sum() < 2:
        return None
    change = ours[both] - theirs[both]
    moved = change[change != 0.0]
    p, effect = 1.0, 0.0
    if len(moved):
        ranks = stats.rankdata(np.abs(moved))
        effect = float((ranks * np.sign(moved)).sum() / ranks.sum())
        exact = len(moved) <= 50 and len(np.unique(np.abs(moved))) == len(moved)
        p = float(stats.wilcoxon(moved, method="exact" if exact else "approx").pvalue)
    return Difference(
        difference=float(change.mean()),
        interval=mean_interval(change),
        p=p,
        effect=effect,
        worlds=len(change),
        test="Wilcoxon signed-rank",
    )


def holm(p: Sequence[float]) -> list[float]:
    """The p-values of comparisons made at once, corrected: the least of m stands m times.

    S. Holm, "A simple sequentially rejective multiple test procedure", Scand. J. Stat. 6, 1979, in
    the form of S. P. Wright, "Adjusted p-values for simultaneous inference", 1992. Whatever is
    called a difference because its value is below 0.05 is wrong, even once among all, in at most
    one family of twenty, however the comparisons hang together.
    """
    corrected, least = [0.0] * len(p), 0.0
    for rank, index in enumerate(sorted(range(len(p)), key=lambda index: p[index])):
        least = max(least, min(1.0, (len(p) - rank) * p[index]))
        corrected[index] = least
    return corrected


def _same(ours: NDArray[Any], theirs: NDArray[Any]) -> None:
    if len(ours) == 0 or ours.shape != theirs.shape:
        raise InvalidInputError(
            f"Results of {len(ours)} and {len(theirs)} worlds cannot be paired; fly both through "
            "the same worlds."
        )
