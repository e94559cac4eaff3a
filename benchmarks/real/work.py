"""The pieces of `benchmarks/real_data.py`, each for a process of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.closed_loop import chunks, play
from benchmarks.real.contenders import CONTENDERS, Contender, fitted
from benchmarks.real.offline import Measured, cleaned_pairs, measure_fold
from benchmarks.real.push import PERCEPTIONS
from benchmarks.real.recordings import (
    Recording,
    data_folder,
    read_door,
    read_push,
    read_targets,
)
from benchmarks.real.tables import Bout
from benchmarks.real.walking import Experiment, displacement, read_walkers, walkers_as_pairs
from evastudio.learning.knn import KNNPolicy

WALKERS = 6000
"""Pairs that learners of walking are fitted to at most."""
NEAREST = Contender("nearest pair", KNNPolicy, ({"k": 1},))
"""What was done at the most similar moment, averaged with nothing."""


@dataclass(frozen=True)
class Job:
    """One piece of work for a process of its own."""

    kind: str
    """push, door, walk or play."""
    number: int
    """Of the fold, or of the contender played; -1 the nearest pair alone."""
    view: int = 0
    """Of the perception, for Push-T."""
    chunk: int = 1
    clean: bool = False


@cache
def walking() -> tuple[tuple[Experiment, ...], Recording]:
    """The experiments and their pairs."""
    experiments = read_walkers(data_folder())
    return experiments, walkers_as_pairs(experiments)


def work(job: Job, folds: int, episodes: int) -> list[Measured] | Bout:
    """Does one job."""
    folder = data_folder()
    if job.kind == "door":
        return measure_fold(read_door(folder), job.number, folds)
    if job.kind == "push":
        recording = read_push(folder, PERCEPTIONS[job.view])
        return measure_fold(recording, job.number, folds, faults=job.view == 0)
    if job.kind == "walk":
        experiments, recording = walking()

        def roll_out(learner: Any, groups: NDArray[np.int64]) -> float:
            each = [displacement(learner, experiments[group]) for group in groups]
            return float(np.concatenate(each).mean())

        return measure_fold(recording, job.number, folds, most=WALKERS, roll_out=roll_out)
    return compete(job, episodes)


def compete(job: Job, episodes: int) -> Bout:
    """Fits one contender to all Push-T demonstrations and plays it."""
    folder, perception = data_folder(), PERCEPTIONS[job.view]
    recording = read_push(folder, perception)
    contender = NEAREST if job.number < 0 else CONTENDERS[job.number]
    states, targets = read_targets(folder)
    pairs, groups = (
        chunks(recording.pairs, perception, states, targets, job.chunk),
        recording.groups,
    )
    if job.clean:
        kept = cleaned_pairs(recording.pairs, recording.dt_s)
        pairs, groups = pairs.keep(kept), groups[kept]
    rng = np.random.default_rng(20263)
    learner, settings = fitted(contender, pairs, groups, rng)
    played = play(learner, perception, episodes, job.chunk)
    shown = ", ".join(f"{name} {value}" for name, value in settings.items())
    return Bout(contender.name, perception.name, job.chunk, job.clean, shown, played)
