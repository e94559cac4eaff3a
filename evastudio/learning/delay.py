"""Reaction delay: how long a demonstrator takes to answer what is seen, told by held-out takes.

Every action is paired with the state of so many steps before, for delays from none to 0.6 s, and
each pairing is learned from some takes and tried on the others: the demonstrator answered at the
delay where what was done can be foretold best. It is taken out only where the takes agree that
this helps. On other data than scripted flights, mind that a state which repeats the latest action
(see `diagnostics`) foretells the next one best without any delay, whatever the truth.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import reduce
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ttest_1samp

from evastudio.demonstrations.pairs import Pairs, answered_pairs
from evastudio.errors import InvalidInputError
from evastudio.learning.foretelling import foretold
from evastudio.learning.holdout import some_takes, take_folds
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import Array, finite_rows

Asked = float | Literal["auto", "off"]
"""Which delay to take out: what is estimated where it helps, none, or so many seconds."""

LONGEST_S = 0.6
MOST_S = 2.0
"""No longer delay can be asked for."""
BEYOND_S = 0.2
"""Longer delays are tried too, to see that they tell less."""
MOST_LAGS = 25
"""So many delays are tried at most, evenly spread: every step of 15 a second, every other of 30."""
UNLIKELY = 0.2
"""A delay is not even spoken of where luck alone would show one like it more often than this."""
CHANCE = 0.05
"""A delay counts as real where luck alone would show one like it less often than this. In 600
recordings of slowly changing noise answered at once or not at all, one was found."""
WORTHWHILE = 0.02
"""Share of the squared error that must be gained: less is not worth changing the pairs for."""
STILL = 1e-9
"""Actions that a constant foretells to this share of their spread never change: no delay shows."""
RESAMPLES = 500
MOST_PAIRS = 100_000
"""Of more pairs, every second, third, ... take is looked at, to bound memory."""


@dataclass(frozen=True)
class Delay:
    """How late a demonstrator answered."""

    delay_s: float
    """The estimate, between steps too; 0 where none was found."""
    low_s: float
    high_s: float
    """With the lower end: a 95 % interval, from drawing the takes anew."""
    steps: int
    """Decision steps to take out: 0 where the held-out takes do not agree that it helps."""
    gain: float
    """Share of the squared error on held-out takes that taking the estimate out removes."""
    chance: float
    """How often luck alone would show such a valley (the weakest of three paired t-tests over
    takes: against no delay, a longer one and a constant); 1 where no delay is the best."""
    takes: int
    """How many takes it is told from."""
    lags_s: tuple[float, ...]
    """The delays tried."""
    errors: tuple[float, ...]
    """Error on held-out takes at each of them; about 1 is a constant's at none."""
    asked: Asked = "auto"
    """Where this is not "auto", nothing was estimated."""

    @property
    def helps(self) -> bool:
        """Whether it is to be taken out."""
        return self.steps > 0

    def sentence(self) -> str:
        """What it says, to the demonstrator."""
        if self.asked == "off":
            return "No delay was looked for, as you asked."
        if self.asked != "auto":
            return f"A delay of {self.delay_s:.2g} s was taken out, as you asked."
        if self.takes < 2:
            return "Your reaction time was not measured: that needs at least two takes."
        if not self.lags_s:
            return "Your reaction time was not measured: decisions are too far apart in time."
        late = f"{self.delay_s:.{1 if self.delay_s >= 0.05 else 2}f}"
        if self.helps:
            return (
                f"You answered about {late} s late; the policy does not. On takes it "
                f"had not seen, that foretells your moves {100 * self.gain:.0f} % better."
            )
        if self.delay_s > 0.0 and self.chance < UNLIKELY:
            return (
                f"You may have answered about {late} s late, but the takes do not "
                "agree enough to take it out. More takes will tell."
            )
        return "No delay was found between what you saw and what you did."

    def report(self) -> dict[str, Any]:
        """The figures and the sentence, as JSON holds them."""
        return {**asdict(self), "sentence": self.sentence()}


def estimate_delay(
    pairs_at: Callable[[int], Pairs], dt_s: float, *, longest_s: float = LONGEST_S, seed: int = 0
) -> Delay:
    """How late the actions answer the states.

    `pairs_at(d)` gives the pairs with a delay of d steps taken out, by take and step in the same
    order for every d. Every delay is judged on the actions that all of them have. `seed` decides
    the draws behind the interval.
    Raises InvalidInputError for a step that is not above 0, NaN and infinities.
    """
    if not (np.isfinite(dt_s) and dt_s > 0.0):
        raise InvalidInputError(f"The decision step is {dt_s} s; it must be more than 0.")
    most = int((longest_s + BEYOND_S) / dt_s + 1e-9)
    lags = np.arange(0, most + 1, max(1, -(-most // (MOST_LAGS - 1))))
    looked_at = some_takes(pairs_at(0).takes, MOST_PAIRS)
    paired = _of_same_actions([_of_takes(pairs_at(int(lag)), looked_at) for lag in lags], most)
    takes = paired[0].takes
    names, take_of, sizes = np.unique(takes, return_inverse=True, return_counts=True)
    if len(names) < 2 or len(lags) < 3:
        return Delay(0.0, 0.0, 0.0, 0, 0.0, 1.0, len(names), (), ())
    folds = take_folds(takes)
    for pairs in paired:
        finite_rows(pairs.states, pairs.states.shape[1], "states")
    finite_rows(paired[0].actions, paired[0].actions.shape[1], "actions")
    unit = Scaling.of(paired[0].actions).scale
    wrong = [foretold(pairs.states, pairs.actions, folds, unit) for pairs in paired]
    by_take = np.array([np.bincount(take_of, row) / sizes for row in wrong])
    errors = by_take @ sizes / len(takes)
    within = int((lags * dt_s <= longest_s + 1e-9).sum())
    nothing = np.empty((len(takes), 0))
    constant = np.bincount(take_of, foretold(nothing, paired[0].actions, folds, unit)) / sizes
    best = 0
    if constant.max() > STILL:
        best = _smallest_as_good(by_take[:within], errors[:within])
    steps = _vertex(lags, errors, best)
    drawn = np.random.default_rng(seed).choice(len(names), (RESAMPLES, len(names)))
    often = np.stack([np.bincount(draw, minlength=len(names)) for draw in drawn])
    curves = often @ (by_take * sizes).T / (often @ sizes)[:, None]
    found = [
        _vertex(lags, curve, _smallest_as_good(by_take[:within, draw], curve[:within]))
        for curve, draw in zip(curves, drawn, strict=True)
    ]
    low, high = np.quantile(found, (0.025, 0.975))
    # A real delay is a valley: none, a longer one and a mere constant all tell less.
    gain = float(1.0 - errors[best] / errors[0]) if errors[0] > 0.0 else 0.0
    longer = best + int(errors[best:].argmax())
    chance = max(
        _luck(by_take[0], by_take[best]),
        _luck(by_take[longer], by_take[best]),
        _luck(constant, by_take[best]),
    )
    helps = best > 0 and chance < CHANCE and gain >= WORTHWHILE
    return Delay(
        delay_s=float(steps * dt_s),
        low_s=float(min(low, steps) * dt_s),
        high_s=float(max(high, steps) * dt_s),
        steps=round(steps) if helps else 0,
        gain=gain,
        chance=min(chance, 1.0),
        takes=len(names),
        lags_s=tuple(float(lag * dt_s) for lag in lags),
        errors=tuple(float(error) for error in np.sqrt(errors)),
    )


def delay_as_asked(asked: Asked | str, pairs_at: Callable[[int], Pairs], dt_s: float) -> Delay:
    """The estimate for "auto", none for "off", or the given seconds, in whole steps.

    Raises InvalidInputError for anything else, and for seconds below 0 or above 2.
    """
    if asked == "auto":
        return estimate_delay(pairs_at, dt_s)
    given = 0.0 if asked == "off" else asked
    if isinstance(given, str) or not 0.0 <= given <= MOST_S:
        raise InvalidInputError(
            f"The delay is {asked!r}; it must be 'auto', 'off' or seconds from 0 to {MOST_S:g}."
        )
    steps = round(given / dt_s)
    seconds = steps * dt_s
    told: Asked = "off" if asked == "off" else seconds
    return Delay(seconds, seconds, seconds, steps, 0.0, 1.0, 0, (), (), told)


def estimate_delay_of_arrays(
    states: Array,
    actions: Array,
    takes: NDArray[np.int64],
    dt_s: float,
    *,
    longest_s: float = LONGEST_S,
    seed: int = 0,
) -> Delay:
    """The same for recordings without snapshots, whose actions are in one frame all along.

    states (pairs, n), actions (pairs, m), takes (pairs,): the rows of a take in order, one for
    each step of `dt_s` seconds. `answered_pairs` then takes the delay out.
    """
    pairs = in_order(states, actions, takes)
    return estimate_delay(
        lambda steps: answered_pairs(pairs, steps), dt_s, longest_s=longest_s, seed=seed
    )


def in_order(states: Array, actions: Array, takes: NDArray[np.int64]) -> Pairs:
    """Arrays as pairs, their steps counted from 0 in each take; for recordings from elsewhere."""
    takes = np.asarray(takes, dtype=np.int64)
    steps = np.empty_like(takes)
    for take in np.unique(takes):
        rows = takes == take
        steps[rows] = np.arange(rows.sum())
    actions = np.asarray(actions, dtype=np.float64)
    return Pairs(
        np.asarray(states, dtype=np.float64),
        actions[:, None] if actions.ndim == 1 else actions,
        takes,
        steps,
    )


def _of_takes(pairs: Pairs, takes: NDArray[np.int64]) -> Pairs:
    return pairs.keep(np.isin(pairs.takes, takes))


def _of_same_actions(paired: list[Pairs], step: int) -> list[Pairs]:
    """Of each pairs those whose actions all of them have, from `step` on in every take."""
    latest = 1 + max(int(pairs.steps.max(initial=0)) for pairs in paired)
    keys = [pairs.takes * latest + pairs.steps for pairs in paired]
    common = reduce(np.intersect1d, keys)
    return [
        pairs.keep(np.isin(key, common) & (pairs.steps >= step))
        for pairs, key in zip(paired, keys, strict=True)
    ]


def _smallest_as_good(by_take: Array, errors: Array) -> int:
    """The smallest delay whose errors (lags, takes) are within a standard error of the best's."""
    best = int(errors.argmin())
    for at in range(best):
        more = by_take[at] - by_take[best]
        if more.mean() <= more.std(ddof=1) / np.sqrt(len(more)):
            return at
    return best


def _vertex(lags: NDArray[np.int64], errors: Array, at: int) -> float:
    """Where the parabola through the errors beside `at` is least; `at` itself where none is."""
    if not 0 < at < len(lags) - 1 or not errors[at] < min(errors[at - 1], errors[at + 1]):
        return float(lags[at])
    bend, slope, _ = np.polyfit(lags[at - 1 : at + 2] - lags[at], errors[at - 1 : at + 2], 2)
    return float(lags[at] - slope / (2.0 * bend))


def _luck(before: Array, after: Array) -> float:
    """How often luck alone makes the errors of takes (takes,) fall like this, from 0 to 1.

    By a paired t-test on by what factor each fell, so that hard takes count like easy ones.
    """
    least = 1e-12 * before.max() if before.max() > 0.0 else 1.0
    factors = np.log(np.maximum(before, least) / np.maximum(after, least))
    if factors.std() <= 1e-12 * np.abs(factors).max():
        return 0.0 if factors[0] > 0.0 else 1.0
    return float(ttest_1samp(factors, 0.0, alternative="greater").pvalue)
