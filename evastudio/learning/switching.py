"""Learning when to switch from takes in which the animator marked it (paper, section 5).

A take says of each of its moments whether it lies before or after the mark. Sought is a condition
of few bounds under which a switchboard would have switched where the animator did. What counts is
that: how many decisions the switch would come early or late, not how many moments are told apart.
So one mark among a thousand moments counts in full, and moments after the mark say nothing where
a switch is for good.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import Progress, silent
from evastudio.world.conditions import Bound, Condition
from evastudio.world.spaces import Array

Mask = NDArray[np.bool_]
Counts = NDArray[np.int64]

MOST_BOUNDS = 4
"""A box on the ground has as many sides."""
WIDTH = 12
"""Conditions that are followed up at once."""
TRIED = 48
"""Limits tried for one reading, of each side."""
CAP = 16
"""A take in which the switch comes more decisions early or late than this is simply missed."""
WORTH = 0.25
"""Decisions in each take that a further bound must save to be believed."""
DIGITS = 9
"""Decimals of a reading that mean something."""
LATEST = 3
"""Decisions that an animator may be late with the mark."""
NEAR = 1
"""Decisions early or late within which a switch counts as the animator's."""
SLIGHT = 0.25
"""What such a decision counts: nobody marks to the decision."""


@dataclass(frozen=True)
class MarkedTakes:
    """What could be read at every moment of some takes, and which moments were marked."""

    names: tuple[str, ...]
    """Of the readings; those that explain equally well are preferred in this order."""
    readings: Array
    """Shape (moments, readings), the takes one behind the other."""
    lengths: Counts
    """Moments of each take, shape (takes,)."""
    marks: Mask
    """Shape (moments,). From a mark on the other policy should act, and from the next the first
    again."""

    def __post_init__(self) -> None:
        moments = int(self.lengths.sum())
        if self.readings.shape != (moments, len(self.names)) or self.marks.shape != (moments,):
            raise InvalidInputError(
                f"There are {moments} moments, readings of shape {self.readings.shape} for "
                f"{len(self.names)} names, and {len(self.marks)} marks; they must agree."
            )

    @cached_property
    def starts(self) -> Counts:
        """Where each take begins, shape (takes,)."""
        return np.asarray(np.cumsum(self.lengths) - self.lengths)

    @cached_property
    def step(self) -> Counts:
        """Of each moment, within its take."""
        return np.arange(len(self.marks)) - np.repeat(self.starts, self.lengths)

    @cached_property
    def once(self) -> bool:
        """Whether every switch is for good: no take has a second mark."""
        return bool((np.add.reduceat(self.marks.astype(np.int64), self.starts) <= 1).all())

    def first(self, mask: Mask) -> Counts:
        """The step at which `mask` (..., moments) is first true in each take, else its length."""
        at = np.where(mask, self.step, np.repeat(self.lengths, self.lengths))
        return np.asarray(np.minimum.reduceat(at, self.starts, axis=-1))

    @cached_property
    def after(self) -> Mask:
        """At which moments the other policy should act, (moments,)."""
        marked: Counts = np.cumsum(self.marks)
        before: Counts = np.repeat(marked[self.starts] - self.marks[self.starts], self.lengths)
        return np.asarray((marked - before) % 2 == 1)

    def acting(self, holds: Mask, once: bool) -> Mask:
        """Where the other policy would act if a condition held at the moments `holds`, (moments,),
        and if it then did for good."""
        if not once:
            return holds
        return np.asarray(self.step >= np.repeat(self.first(holds), self.lengths, axis=-1))

    def off(self, holds: Mask) -> Array:
        """At how many decisions of each take the wrong one would act, (..., takes).

        Where a switch is for good they count up to CAP, and slightly while they are NEAR; where
        it is not, those of the policy that acts more rarely count more, so that each has half of
        the weight.
        """
        if self.once:
            apart = np.minimum(np.abs(self.first(holds) - self.first(self.marks)), CAP)
            slight = np.where(apart <= NEAR, SLIGHT * apart, apart - (1.0 - SLIGHT) * NEAR)
            return np.asarray(slight)
        share = np.clip(self.after.mean(), 1e-9, 1.0 - 1e-9)
        weight = np.where(self.after, 0.5 / share, 0.5 / (1.0 - share))
        return np.asarray(np.add.reduceat((holds != self.after) * weight, self.starts, axis=-1))

    def near(self, acting: Mask) -> Mask:
        """In which takes every switch falls within NEAR decisions of its mark, (takes,), if the
        other policy acts at the moments `acting`, (moments,)."""
        would, should = self._changes(acting), self._changes(self.after)
        return np.array(
            [
                len(one) == len(other) and bool((np.abs(one - other) <= NEAR).all())
                for one, other in zip(would, should, strict=True)
            ]
        )

    def _changes(self, acting: Mask) -> list[Counts]:
        """The steps of each take at which another policy acts than before."""
        was = np.concatenate([[False], acting[:-1]])
        was[self.starts] = False
        changed = acting != was
        return [
            np.flatnonzero(changed[start : start + length])
            for start, length in zip(self.starts, self.lengths, strict=True)
        ]

    def earlier(self, steps: int) -> MarkedTakes:
        """As if every mark had been given so many decisions earlier, but within its take."""
        at = np.flatnonzero(self.marks)
        marks = np.zeros_like(self.marks)
        marks[at - np.minimum(self.step[at], steps)] = True
        return replace(self, marks=marks)

    def only(self, takes: ArrayLike) -> MarkedTakes:
        """Some of the takes, by number, in order."""
        chosen = np.isin(np.arange(len(self.lengths)), takes)
        rows = np.repeat(chosen, self.lengths)
        return MarkedTakes(self.names, self.readings[rows], self.lengths[chosen], self.marks[rows])


@dataclass(frozen=True)
class LearnedSwitch:
    """A condition, and how well it tells the marks it was learned from."""

    condition: Condition
    takes: int
    marks: int
    delay_steps: int
    """How late the marks seem to have been given; taken out of the condition."""
    near: int
    """Of the takes, each left out in turn: in how many every switch would have fallen within one
    decision of its mark."""

    def sentence(self, dt_s: float) -> str:
        """What to tell the animator."""
        late = f" You marked about {self.delay_steps * dt_s:g} s late." if self.delay_steps else ""
        doubt = (
            " It does not tell your marks well: mark more takes, or write the condition."
            if self.near < 0.8 * self.takes
            else ""
        )
        return (
            f"Learned from {self.marks} marks in {self.takes} takes. In {self.near} of them it "
            f"would have switched within one decision of your mark without having seen the take."
            f"{late}{doubt}"
        )

    def to_json(self) -> dict[str, Any]:
        return {
            "takes": self.takes,
            "marks": self.marks,
            "delay_steps": self.delay_steps,
            "near": self.near,
        }


def learn_switch(marked: MarkedTakes, progress: Progress = silent) -> LearnedSwitch:
    """The condition under which a switch falls where `marked` has its marks.

    Raises InvalidInputError where nothing is marked.
    """
    if not marked.marks.any():
        raise InvalidInputError(
            "No moment is marked in the kept takes. Press the key that marks a moment where the "
            "switch should fall, in a few takes, and learn again."
        )
    worth = WORTH * len(marked.lengths)
    trials = [_search(marked.earlier(steps)) for steps in range(LATEST + 1)]
    costs = [
        found.wrong + worth * (len(found.bounds) + bool(late)) for late, found in enumerate(trials)
    ]
    late = int(np.argmin(costs))  # believing in a delay costs as much as a further bound
    prompt = marked.earlier(late)
    takes = np.arange(len(marked.lengths))
    near = 0
    for take in takes:
        progress(float(take) / len(takes), "Trying it on takes left out")
        rest, alone = prompt.only(takes[takes != take]), prompt.only([take])
        if rest.marks.any():
            holds = _holds(alone, _settled(rest, _search(rest)))
            near += bool(alone.near(alone.acting(holds, marked.once))[0])
    progress(1.0, "Learned")
    condition = Condition(_settled(prompt, trials[late]), marked.once)
    return LearnedSwitch(condition, len(takes), int(marked.marks.sum()), late, near)


@dataclass(frozen=True)
class _Found:
    """Some bounds, and what they come to."""

    bounds: tuple[Bound, ...]
    holds: Mask
    wrong: float
    """Decisions that are wrong, in all takes together; see `MarkedTakes.off`."""


def _search(marked: MarkedTakes) -> _Found:
    """A beam search: bounds are added one at a time while they are worth it."""
    everywhere = np.ones(len(marked.marks), dtype=np.bool_)
    best = _Found((), everywhere, np.inf)
    beam = [best]
    limits = [_limits(marked, column) for column in marked.readings.T]
    for _ in range(MOST_BOUNDS):
        grown: list[_Found] = []
        for found in beam:
            for number, name in enumerate(marked.names):
                for low in (True, False):
                    grown += _tried(marked, found, number, name, limits[number], low)
        grown.sort(key=lambda found: found.wrong)
        beam = _different(grown)
        if not beam or beam[0].wrong > best.wrong - WORTH * len(marked.lengths):
            break
        best = beam[0]
    return best


def _tried(
    marked: MarkedTakes, found: _Found, number: int, name: str, limits: Array, low: bool
) -> list[_Found]:
    """`found` with one more bound on a reading, the best few of its `limits`."""
    values = marked.readings[:, number]
    fits = values >= limits[:, None] if low else values <= limits[:, None]
    holds = found.holds & fits
    wrong = marked.off(holds).sum(axis=1)
    few = np.argsort(wrong, kind="stable")[:3]
    return [
        _Found(
            (*found.bounds, Bound(name, low=limits[at]) if low else Bound(name, high=limits[at])),
            holds[at],
            float(wrong[at]),
        )
        for at in few
    ]


def _different(grown: list[_Found]) -> list[_Found]:
    """The first WIDTH of them that do not hold at the same moments."""
    kept: dict[bytes, _Found] = {}
    for found in grown:
        kept.setdefault(np.packbits(found.holds).tobytes(), found)
        if len(kept) == WIDTH:
            break
    return list(kept.values())


def _limits(marked: MarkedTakes, values: Array) -> Array:
    """Where a bound on a reading (moments,) could lie: between values at marks, and in between."""
    at, last = np.flatnonzero(marked.marks), len(values) - 1
    around = [
        (values[np.minimum(at + shift, last)] + values[np.maximum(at + shift - 1, 0)]) / 2
        for shift in (0, 1)
    ]
    known = np.unique(values.round(DIGITS))
    between = (known[1:] + known[:-1]) / 2
    if len(between) > TRIED:
        spread = np.quantile(between, np.linspace(0.0, 1.0, TRIED))
        between = np.concatenate([spread, *around])
    return np.unique(between)


def _holds(marked: MarkedTakes, bounds: Sequence[Bound]) -> Mask:
    readings = dict(zip(marked.names, marked.readings.T, strict=True))
    return Condition(tuple(bounds)).holds(readings)


def _settled(marked: MarkedTakes, found: _Found) -> tuple[Bound, ...]:
    """The bounds of `found`, each moved to the middle of where it serves equally well."""
    bounds = list(found.bounds)
    for number, bound in enumerate(bounds):
        others = [one for one in bounds if one is not bound]
        rest = _holds(marked, others) if others else np.ones(len(marked.marks), dtype=np.bool_)
        values = marked.readings[:, marked.names.index(bound.reading)]
        low = np.isfinite(bound.low)
        limit = bound.low if low else bound.high
        known = np.unique(values.round(DIGITS))
        place = int(np.searchsorted(known, limit))
        edges = known[max(place - TRIED, 0) : place + TRIED]
        between = (edges[1:] + edges[:-1]) / 2
        fits = values >= between[:, None] if low else values <= between[:, None]
        wrong = marked.off(rest & fits).sum(axis=1)
        good = np.flatnonzero(wrong == wrong.min())
        run = good[good - np.arange(len(good)) == good[0]] if len(good) else good
        if len(good):
            middle = float((edges[run[0]] + edges[run[-1] + 1]) / 2)
            bounds[number] = (
                Bound(bound.reading, low=middle) if low else Bound(bound.reading, high=middle)
            )
    return _merged(bounds)


def _merged(bounds: Sequence[Bound]) -> tuple[Bound, ...]:
    """The same with one bound for each reading."""
    low: dict[str, float] = {}
    high: dict[str, float] = {}
    for bound in bounds:
        low[bound.reading] = max(low.get(bound.reading, -np.inf), bound.low)
        high[bound.reading] = min(high.get(bound.reading, np.inf), bound.high)
    return tuple(Bound(reading, low[reading], high[reading]) for reading in low)
