"""Where is the paper's plain state enough, the orientation and the two nearest asteroids?

    python -m benchmarks.reproduction            # the tables in docs/reproduction.md, and a figure
    python -m benchmarks.reproduction --quick    # one set, few pairs and fields, no document

Every setting of a learner is chosen for every cell anew, on a demonstration and fields of other
seeds than those of the tables.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import joblib
import numpy as np

from benchmarks.atlas import SETS, TUNED_ON, TUNING_FIELDS, TUNING_SET, Atlas, draw, report
from benchmarks.crossing import FIELDS
from benchmarks.plain_state import DEMONSTRATORS, Cell, Found, references, whole_map
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.flight import Logbook
from evastudio.evaluation.results import Evaluation
from evastudio.learning.checking import checked_pairs
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.policy import Policy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import ScriptedPilot
from evastudio.pilots.straight import StraightPilot
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import world_seeds
from evastudio.world.spaces import Array


class RawKNN(KNNPolicy):
    """On states as they are, metres beside angles of which a `radian` counts so much."""

    def __init__(self, k: int, radian: float) -> None:
        super().__init__(k)
        self.radian = radian

    def fit(self, states: Any, actions: Any = None) -> RawKNN:
        super().fit(states, actions)
        self.offset_, self.scale_ = as_they_are(states, self.radian)
        self.states_ = states / self.scale_
        return self.prepare()


class RawSVR(SVRPolicy):
    """The same for an SVR."""

    def __init__(self, gamma: float, radian: float) -> None:
        super().__init__(gamma=gamma, epsilon=0.1)
        self.radian = radian

    def fit(self, states: Any, actions: Any = None, **_: Any) -> RawSVR:
        states, actions = checked_pairs(self, states, actions)
        self.offset_, self.scale_ = as_they_are(states, self.radian)
        self.half_, self.middle_ = np.abs(actions).max(axis=0), np.zeros(actions.shape[1])
        self._settle(states / self.scale_, actions, None)
        return self.prepare()


def as_they_are(states: Array, radian: float) -> tuple[Array, Array]:
    """Offset and scale that leave all but the angles alone."""
    scale = np.ones(states.shape[1])
    scale[:2] = 1.0 / radian
    return np.zeros(states.shape[1]), scale


DEGREES = float(np.degrees(1.0))
NEIGHBORS, GAMMAS, RAW_GAMMAS = (1, 3, 7), (0.01, 0.03, 0.1, 0.3), (0.001, 0.003)
LEARNERS: Mapping[str, Mapping[str, Callable[[], Any]]] = {
    "knn": {f"k {k}": partial(KNNPolicy, k) for k in NEIGHBORS},
    "svr": {f"gamma {g:g}": partial(SVRPolicy, gamma=g, epsilon=0.1) for g in GAMMAS},
    "knn, radians": {f"k {k}": partial(RawKNN, k, 1.0) for k in NEIGHBORS},
    "knn, degrees": {f"k {k}": partial(RawKNN, k, DEGREES) for k in NEIGHBORS},
    "svr, radians": {f"gamma {g:g}": partial(RawSVR, g, 1.0) for g in RAW_GAMMAS},
    "svr, degrees": {f"gamma {g:g}": partial(RawSVR, g, DEGREES) for g in RAW_GAMMAS},
}
"""The settings to choose from; where no unit of the angles is said, states are standardised."""


def demonstrator(name: str) -> Pilot:
    return ScriptedPilot(DEMONSTRATORS[name], name)


def shown(cell: Cell, seed: int) -> tuple[Array, Array]:
    """The cell's pairs: states and actions, from whole takes, the last one cut."""
    scene = cell.scene(cell.shown_at)
    view = scene.perception(cell.perception)
    states: list[Array] = []
    actions: list[Array] = []
    seeds = iter(world_seeds(seed, 1000))
    while sum(map(len, states)) < cell.pairs:
        log = Logbook(scene)
        few = [next(seeds) for _ in range(8)]
        roll_out(scene, demonstrator(cell.demonstrator), few, watcher=log)
        for flight in log.flights():
            percept = view.perceive(flight.moments)
            states.append(percept.states)
            actions.append(view.to_own(percept.frame, flight.actions))
    return np.concatenate(states)[: cell.pairs], np.concatenate(actions)[: cell.pairs]


def fitted(cell: Cell, setting: str, states: Array, actions: Array) -> PolicyPilot:
    scene = cell.scene(cell.shown_at)
    view = scene.perception(cell.perception)
    learner = LEARNERS[cell.learner][setting]().fit(states, actions)
    return PolicyPilot(
        Policy(learner, scene.identity(), view.name, view.state, scene.action, len(states), "")
    )


def flown(cell: Cell, pilot: Pilot, density: float, seed: int, fields: int) -> Evaluation:
    scene = cell.scene(density)
    compared = evaluate(scene, {"it": pilot}, worlds=fields, seed=seed, measure_time=False)
    return compared.pilots["it"]


def measured(cell: Cell, sets: Sequence[int], fields: int, tuned_on: int) -> Found:
    """Choose the cell's setting, fit it to each of `sets` and fly it; a setting's ties go to the
    first."""
    pairs = shown(cell, TUNING_SET)
    rates = {}
    for setting in LEARNERS[cell.learner]:
        pilot = fitted(cell, setting, *pairs)
        tries = [flown(cell, pilot, at, TUNING_FIELDS, tuned_on) for at in cell.flown_at]
        rates[setting] = sum(one.success_rate for one in tries)
    best = max(rates, key=lambda setting: rates[setting])
    pilots = [fitted(cell, best, *shown(cell, seed)) for seed in sets]
    return Found(
        best,
        {at: [flown(cell, pilot, at, FIELDS, fields) for pilot in pilots] for at in cell.flown_at},
    )


def itself(cell: Cell, fields: int) -> Found:
    """The cell's demonstrator in the same fields; straight flight where it has no such."""
    known = cell.demonstrator in DEMONSTRATORS
    pilot = demonstrator(cell.demonstrator) if known else StraightPilot()
    return Found("", {at: [flown(cell, pilot, at, FIELDS, fields)] for at in cell.flown_at})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--quick", action="store_true", help="1 set, 300 pairs, 8 fields, no document"
    )
    parser.add_argument("--fields", type=int, default=100, help="fields a policy and density")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="where it is written")
    options = parser.parse_args()
    sets = SETS[:1] if options.quick else SETS
    fields, tuned_on = (8, 4) if options.quick else (options.fields, TUNED_ON)
    at = commit("evastudio", "scenes", "benchmarks")
    began = time.monotonic()
    run = joblib.Parallel(n_jobs=options.jobs, return_as="generator")
    known, cells = references(), whole_map()
    tasks = [joblib.delayed(itself)(cell, fields) for cell in known]
    done = [replace(cell, pairs=300) for cell in cells] if options.quick else cells
    tasks += [joblib.delayed(measured)(cell, sets, fields, tuned_on) for cell in done]
    found = {}
    for cell, one in zip([*known, *cells], run(tasks), strict=True):
        found[cell] = one
        rates = {at: [e.success_rate for e in each] for at, each in one.policies.items()}
        print(f"{time.monotonic() - began:.0f} s", cell, one.setting, rates, flush=True)
    line = where_and_when(at, "python -m benchmarks.reproduction", time.monotonic() - began)
    atlas = Atlas(found)
    text = report(atlas, sets, fields, line)
    print(text)
    if not options.quick:
        write_section(options.docs / "reproduction.md", "reproduction", text)
        draw(atlas, options.docs / "reproduction.svg")


if __name__ == "__main__":
    from benchmarks import reproduction  # under this name other processes find what is cached

    reproduction.main()
