"""Trials: candidates tried on the same held-out takes, and which of them to believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import joblib
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student
from sklearn.base import is_classifier

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.candidates import GRIDS, Candidate
from evastudio.learning.cleaning import N_NEIGHBORS, Progress, clean_pairs, silent
from evastudio.learning.holdout import HoldOut, Mask, mistakes, summed_up, take_folds
from evastudio.world.scene import Perception, Scene
from evastudio.world.spaces import Array

CONFIDENCE = 0.95
"""One-sided, that one candidate errs less than another on takes like these."""
MARGIN = 0.01
"""Share by which an error must fall to count: defaults have proved themselves in the loop of world
and character, which hold-out knows nothing of, and are not left for less."""


@dataclass(frozen=True)
class Trial:
    """What one candidate gave on takes it had not seen."""

    candidate: Candidate
    wrong: Array
    """Mistakes, shape (pairs,); see `holdout.mistakes`."""
    takes: NDArray[np.int64]
    """The take of each pair, shape (pairs,)."""
    symbols: bool

    @cached_property
    def held_out(self) -> HoldOut:
        """The mistakes summed up, over all and for each take."""
        return summed_up(self.wrong, self.takes, self.symbols)

    @cached_property
    def sums(self) -> tuple[NDArray[np.int64], Array, Array]:
        """The takes, how many pairs each has, and the sum of its mistakes, each (takes,)."""
        names, at = np.unique(self.takes, return_inverse=True)
        return (
            names,
            np.bincount(at).astype(np.float64),
            np.asarray(np.bincount(at, self.wrong), dtype=np.float64),
        )

    def mean(self, left_out: int | None = None) -> float:
        """The mean mistake; `left_out` is a take that does not count."""
        names, sizes, sums = self.sums
        counted = names != left_out
        return float(sums[counted].sum() / sizes[counted].sum())

    @cached_property
    def typical(self) -> float:
        """The mean size of a mistake: single large ones, a demonstrator's slips, move it little."""
        return self.typical_without(None)

    def typical_without(self, left_out: int | None) -> float:
        """The same where the take `left_out` does not count."""
        names, sizes, _ = self.sums
        counted = names != left_out
        return float(self._lengths[counted].sum() / sizes[counted].sum())

    @cached_property
    def _lengths(self) -> Array:
        """The sum of the sizes of each take's mistakes, (takes,)."""
        at = np.unique(self.takes, return_inverse=True)[1]
        return np.asarray(np.bincount(at, np.sqrt(self.wrong)), dtype=np.float64)


class Examiner:
    """Tries candidates on takes: each is held out whole in turn, and learned from the others."""

    def __init__(
        self,
        pairs: Pairs,
        scene: Scene,
        perception: str | Perception | None = None,
        *,
        n_neighbors: int = N_NEIGHBORS,
        n_jobs: int = 1,
        progress: Progress = silent,
    ) -> None:
        """`pairs` are perceived through `perception`; `n_neighbors` are those that cleaning
        compares a pair with."""
        self.pairs, self.scene, self.n_neighbors = pairs, scene, n_neighbors
        self.perception = perception
        self.n_jobs, self.progress = n_jobs, progress
        self.folds = take_folds(pairs.takes)
        self._kept: dict[float | str, tuple[Mask, ...]] = {}

    def run(
        self,
        candidates: Sequence[Candidate],
        learners: Sequence[Any] | None = None,
        used: Sequence[Mask] | None = None,
    ) -> list[Trial]:
        """A trial of each candidate, or of the `learners` that stand for them.

        `used`, a mask (pairs,) for each fold, limits what may be learned from. Runs on threads,
        as the kernels let go of Python's lock, so that a job that is killed leaves nothing behind;
        a joblib backend chosen around this call, such as Dask's, goes before.
        """
        made = [one.make() for one in candidates] if learners is None else list(learners)
        actions = self.pairs.actions
        tasks = []
        for candidate, learner in zip(candidates, made, strict=True):
            wanted = actions[:, 0] if is_classifier(learner) else actions
            for fold, held in enumerate(self.folds):
                mask = self._used(candidate.threshold, fold, used)
                tasks.append((learner, self.pairs.states, wanted, held, mask))
        run = joblib.Parallel(n_jobs=self.n_jobs, prefer="threads", return_as="generator")
        parts = run(joblib.delayed(mistakes)(*task) for task in tasks)
        wrong = np.empty((len(made), len(self.pairs)))
        for number, part in enumerate(parts):
            row, fold = divmod(number, len(self.folds))
            wrong[row, self.folds[fold]] = part
            if fold == len(self.folds) - 1:
                self.progress((row + 1) / len(made), "Trying ways to learn")
        return [
            Trial(candidate, wrong[row], self.pairs.takes, is_classifier(made[row]))
            for row, candidate in enumerate(candidates)
        ]

    def taught(
        self, threshold: float | str | None = None, used: Sequence[Mask] | None = None
    ) -> NDArray[np.int64]:
        """How many pairs there are to learn from when each fold is held out, (folds,).

        With a `threshold` after cleaning; `used` as in `run`. Raises InvalidInputError where they
        are too few to be cleaned.
        """
        masks = [self._used(threshold, fold, used) for fold in range(len(self.folds))]
        both = zip(masks, self.folds, strict=True)
        return np.array([(~held if mask is None else ~held & mask).sum() for mask, held in both])

    def _used(
        self, threshold: float | str | None, fold: int, used: Sequence[Mask] | None
    ) -> Mask | None:
        """The pairs of `used` that cleaning leaves in; None for all."""
        limit = None if used is None else used[fold]
        if threshold is None:
            return limit
        kept = self._cleaned(threshold)[fold]
        return kept if limit is None else kept & limit

    def _cleaned(self, threshold: float | str) -> tuple[Mask, ...]:
        """What cleaning keeps when each fold is held out: conflicts are looked for among the takes
        learned from only, as held-out ones must not help to choose."""
        if threshold not in self._kept:
            masks = []
            for held in self.folds:
                kept = np.zeros(len(self.pairs), dtype=bool)
                found = clean_pairs(
                    self.pairs.keep(~held),
                    self.scene,
                    self.perception,
                    n_neighbors=self.n_neighbors,
                    threshold=threshold,
                )
                kept[~held] = ~found.conflicts
                masks.append(kept)
            self._kept[threshold] = tuple(masks)
        return self._kept[threshold]


def gain(before: Trial, after: Trial, left_out: int | None = None) -> tuple[float, float]:
    """By how much mistakes fall from one trial to another, and the standard error of that.

    The takes are what varies, not the frames: the error is that of a mean of pairs drawn take by
    take. `left_out` is a take that does not count.
    """
    names, sizes, sums = before.sums
    counted = names != left_out
    sizes, less = sizes[counted], (sums - after.sums[2])[counted]
    mean = less.sum() / sizes.sum()
    count = len(sizes)
    if count < 2:
        return float(mean), float("inf")
    spread = ((less - mean * sizes) ** 2).sum() * count / (count - 1)
    return float(mean), float(np.sqrt(spread) / sizes.sum())


def is_better(before: Trial, after: Trial, left_out: int | None = None) -> bool:
    """Whether the takes agree that `after` errs less, and by a share worth having.

    Student's t over takes, one-sided 95 %, and `MARGIN`. Nor may its typical mistake be larger: a
    mean of squares can be won on a demonstrator's few slips alone. (The typical mistake alone
    would judge by the many moments where little happens: it praises policies that do too little.)
    """
    mean, error = gain(before, after, left_out)
    least = (1.0 - (1.0 - MARGIN) ** (1.0 if before.symbols else 2.0)) * before.mean(left_out)
    if mean <= least or after.typical_without(left_out) > before.typical_without(left_out):
        return False
    takes = len(before.sums[0]) - (left_out is not None)
    return takes > 1 and mean > float(student.ppf(CONFIDENCE, takes - 1)) * error


def choose(trials: Sequence[Trial], left_out: int | None = None) -> Trial:
    """The first in order of preference that no other is better than.

    Preferred is the learner named first in `GRIDS`, then fewer settings off their defaults, then
    no cleaning. So settings leave their defaults only where the takes agree that it helps.
    """

    def preference(trial: Trial) -> tuple[int, int, float]:
        one = trial.candidate
        off = len(one.settings) + (one.threshold is not None)
        return list(GRIDS).index(one.learner), off, trial.mean(left_out)

    best = min(trials, key=lambda trial: (trial.mean(left_out), preference(trial)))
    standing = [trial for trial in trials if not is_better(trial, best, left_out)]
    return min(standing, key=preference)
