"""Errors on demonstrations that were held out, after what was put into the others."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.contenders import CONTENDERS, Contender, fitted
from benchmarks.real.faults import with_delay, with_outliers
from benchmarks.real.recordings import Recording
from evastudio.demonstrations.pairs import Pairs, answered_pairs
from evastudio.learning.cleaning import GAP_S, N_NEIGHBORS
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.delay import estimate_delay_of_arrays
from evastudio.learning.holdout import take_folds

OUTLIERS = 0.1
DELAYS_S = (0.3,)
RAW, CLEANED = "as recorded", "as recorded, cleaned"
SPOILT, RESCUED = "10 % outliers", "10 % outliers, cleaned"


def late(delay_s: float) -> str:
    """The name of the condition where answers come `delay_s` late."""
    return f"{delay_s:g} s late"


def on_time(delay_s: float) -> str:
    """The name of the condition where that delay was estimated and taken out."""
    return f"{late(delay_s)}, taken out"


CONDITIONS = (
    RAW,
    CLEANED,
    SPOILT,
    RESCUED,
    *(name(delay) for delay in DELAYS_S for name in (late, on_time)),
)


@dataclass(frozen=True)
class Measured:
    """One learner, fitted to one training part, asked about the part held out."""

    recording: str
    fold: int
    condition: str
    learner: str
    error: float
    """Root mean square error; each component in units of its standard deviation over the whole
    recording, all components counting the same: a constant makes about 1."""
    cut: float
    """Share of the training pairs that cleaning left out."""
    marked: float
    """Share of the outliers put in that cleaning left out; NaN where none were put in."""
    rolled: float
    """Mean distance to where people went, in m, where rollouts were asked for; else NaN."""
    settings: str
    """What was chosen on demonstrations held out of the training part."""


@dataclass(frozen=True)
class Lesson:
    """The pairs to learn from in one condition."""

    condition: str
    pairs: Pairs
    groups: NDArray[np.int64]
    cut: float = 0.0
    marked: float = float("nan")


def cleaned_pairs(pairs: Pairs, dt_s: float) -> NDArray[np.bool_]:
    """Which pairs the studio's cleaning keeps at its automatic threshold, shape (pairs,)."""
    eliminator = ConflictEliminator(N_NEIGHBORS, "auto", gap=max(1, round(GAP_S / dt_s)))
    eliminator.fit(pairs.states, pairs.actions, pairs.moments)
    return np.asarray(~eliminator.conflict_mask_)


def cleaned(lesson: Lesson, condition: str, original: Pairs, dt_s: float) -> Lesson:
    """The lesson without what `ConflictEliminator` marks at its automatic threshold."""
    pairs = lesson.pairs
    kept = cleaned_pairs(pairs, dt_s)
    conflict = ~kept
    put_in = (pairs.actions != original.actions).any(axis=1)
    marked = float(conflict[put_in].mean()) if put_in.any() else float("nan")
    return Lesson(condition, pairs.keep(kept), lesson.groups[kept], float(conflict.mean()), marked)


def lessons(
    pairs: Pairs,
    groups: NDArray[np.int64],
    dt_s: float,
    rng: np.random.Generator,
    faults: bool = True,
) -> Iterator[Lesson]:
    """The training part in every condition; only as recorded, cleaned or not, without `faults`."""
    raw = Lesson(RAW, pairs, groups)
    yield raw
    yield cleaned(raw, CLEANED, pairs, dt_s)
    if not faults:
        return
    spoilt = Lesson(SPOILT, with_outliers(pairs, OUTLIERS, rng), groups)
    yield spoilt
    yield cleaned(spoilt, RESCUED, pairs, dt_s)
    group_of = dict(zip(pairs.takes.tolist(), groups.tolist(), strict=True))
    for delay_s in DELAYS_S:
        steps = round(delay_s / dt_s)
        if abs(steps * dt_s - delay_s) > delay_s / 4:
            continue  # the recording's steps are too long for it
        delayed = with_delay(pairs, steps)
        for name, taught in ((late, delayed), (on_time, answered_in_time(delayed, dt_s))):
            regrouped = np.array([group_of[take] for take in taught.takes.tolist()])
            yield Lesson(name(delay_s), taught, regrouped)


def answered_in_time(pairs: Pairs, dt_s: float) -> Pairs:
    """The pairs without the delay that the studio's estimate decides to take out."""
    found = estimate_delay_of_arrays(pairs.states, pairs.actions, pairs.takes, dt_s)
    return pairs if found.steps == 0 else answered_pairs(pairs, found.steps)


def measure_fold(
    recording: Recording,
    fold: int,
    folds: int,
    contenders: Sequence[Contender] = CONTENDERS,
    most: int | None = None,
    faults: bool = True,
    roll_out: Callable[[Any, NDArray[np.int64]], float] | None = None,
) -> list[Measured]:
    """Everyone in every condition, `fold` of `folds` held out.

    Whole takes of about `most` pairs are learned from, all if None. `roll_out` is asked, for what
    was fitted as recorded, about the groups that were held out.
    """
    warnings.filterwarnings("ignore", message="Stochastic Optimizer: Maximum iterations")
    pairs, groups = recording.pairs, recording.groups
    held = take_folds(groups, folds)[fold]
    rng = np.random.default_rng([20262, fold])
    taught = np.flatnonzero(~held)
    if most is not None and len(taught) > most:
        takes = rng.permutation(np.unique(pairs.takes[taught]))
        sizes = np.bincount(pairs.takes)[takes]
        enough = takes[: int(np.searchsorted(np.cumsum(sizes), most)) + 1]
        taught = taught[np.isin(pairs.takes[taught], enough)]
    learned = np.zeros(len(pairs), dtype=bool)
    learned[taught] = True
    spread = pairs.actions.std(axis=0)
    asked = pairs.keep(held)
    rows: list[Measured] = []
    previous: Pairs | None = None
    for lesson in lessons(pairs.keep(learned), groups[learned], recording.dt_s, rng, faults):
        if lesson.pairs is previous:  # no delay was taken out: nothing else would be learned
            rows += [replace(row, condition=lesson.condition) for row in rows[-len(contenders) :]]
            continue
        previous = lesson.pairs
        for contender in contenders:
            learner, settings = fitted(contender, lesson.pairs, lesson.groups, rng)
            given = np.asarray(learner.predict(asked.states))
            error = float(np.sqrt((((given - asked.actions) / spread) ** 2).mean()))
            chosen = ", ".join(f"{name} {value}" for name, value in settings.items())
            rolled = float("nan")
            if roll_out is not None and lesson.condition in (RAW, CLEANED):
                rolled = roll_out(learner, np.unique(groups[held]))
            rows.append(
                Measured(
                    recording.name,
                    fold,
                    lesson.condition,
                    contender.name,
                    error,
                    lesson.cut,
                    lesson.marked,
                    rolled,
                    chosen,
                )
            )
    return rows
