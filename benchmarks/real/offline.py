"""Errors on demonstrations that were held out, after what was put into the others."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.contenders import CONTENDERS, Contender, fitted
from benchmarks.real.faults import with_delay, with_outliers
from benchmarks.real.recordings import Recording
from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.holdout import take_folds

OUTLIERS = 0.1
DELAYS_S = (0.2, 0.4)
RAW, CLEANED = "as recorded", "as recorded, cleaned"
SPOILT, RESCUED = "10 % outliers", "10 % outliers, cleaned"


def late(delay_s: float) -> str:
    """The name of the condition where answers come `delay_s` late."""
    return f"{delay_s:g} s late"


CONDITIONS = (RAW, CLEANED, SPOILT, RESCUED, *(late(delay) for delay in DELAYS_S))


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


def cleaned_pairs(pairs: Pairs) -> NDArray[np.bool_]:
    """Which pairs `ConflictEliminator` keeps at its automatic threshold, shape (pairs,)."""
    eliminator = ConflictEliminator(threshold="auto").fit(pairs.states, pairs.actions)
    return np.asarray(~eliminator.conflict_mask_)


def cleaned(lesson: Lesson, condition: str, original: Pairs) -> Lesson:
    """The lesson without what `ConflictEliminator` marks at its automatic threshold."""
    pairs = lesson.pairs
    kept = cleaned_pairs(pairs)
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
    yield cleaned(raw, CLEANED, pairs)
    if not faults:
        return
    spoilt = Lesson(SPOILT, with_outliers(pairs, OUTLIERS, rng), groups)
    yield spoilt
    yield cleaned(spoilt, RESCUED, pairs)
    group_of = dict(zip(pairs.takes.tolist(), groups.tolist(), strict=True))
    for delay_s in DELAYS_S:
        steps = round(delay_s / dt_s)
        if abs(steps * dt_s - delay_s) > delay_s / 4:
            continue  # the recording's steps are too long for it
        delayed = with_delay(pairs, steps)
        regrouped = np.array([group_of[take] for take in delayed.takes.tolist()])
        yield Lesson(late(delay_s), delayed, regrouped)


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
    rows = []
    for lesson in lessons(pairs.keep(learned), groups[learned], recording.dt_s, rng, faults):
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
