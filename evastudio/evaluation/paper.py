"""The paper's case study of the spaceship pilot, measured here: tables 1 and 2.

One demonstration by a scripted pilot, cleaned and fitted; PEGASUS and A* beside it; all of them
through the same fields. `paper_tables` sets what is found beside the paper's own figures.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import joblib
import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.evaluation.evaluate import Progress, evaluate
from evastudio.evaluation.paper_costs import Costs, Crossing, costs, cross
from evastudio.evaluation.results import Comparison
from evastudio.learning.cleaning import Cleaning, clean_pairs
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy import Policy
from evastudio.pilots.astar import AStarPilot
from evastudio.pilots.pegasus import Pegasus, Round
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds

PERCEPTION = "canonical"
"""The paper's plain state crosses no dense field here; `docs/results.md` has its figures."""
KNN, SVM, COMPACT, ASTAR = "k-NN", "SVM", "SVM, 256 bases", "A*"
LEARNERS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    KNN: ("knn", {}),
    SVM: ("svr", {}),
    COMPACT: ("svr", {"bases": 256}),
}
DEMONSTRATOR = "scripted:human"
FLOWN = (KNN, SVM, COMPACT, ASTAR)
"""What is flown alone with a clock, beside what the searches find."""


@dataclass(frozen=True)
class Extent:
    """How much is measured."""

    pairs: int = 6000
    """As in the paper."""
    densities: tuple[float, ...] = (1.0, 2.0, 4.0, 6.0)
    """Expected hits of a straight flight."""
    at: float = 4.0
    """The one of them at which is demonstrated, searched and timed."""
    half_width_m: float = 100.0
    """Of the corridor."""
    worlds: int = 60
    """Fields at each density."""
    timed: int = 10
    """Fields flown alone, with a clock at each decision."""
    repeats: int = 5
    """Timings of which the median counts."""
    searches: tuple[Pegasus, ...] = field(
        default_factory=lambda: (
            Pegasus(optimiser="hill-climbing", spread=0.2, rounds=40, seed=9001),
            Pegasus(rounds=40, seed=9001),
        )
    )
    seed: int = 9001
    """Of the demonstration."""
    fields_seed: int = 20261

    def __post_init__(self) -> None:
        if self.at not in self.densities:
            raise InvalidInputError(
                f"The density {self.at:g} is none of {self.densities}; choose one of them."
            )


QUICK = Extent(
    densities=(1.0, 4.0),
    worlds=40,
    timed=3,
    repeats=3,
    searches=(Pegasus(optimiser="hill-climbing", spread=0.2, rounds=15, seed=9001),),
)
"""A few minutes."""


@dataclass(frozen=True)
class Search:
    """What PEGASUS found, and how."""

    policy: Policy
    rounds: tuple[Round, ...]


@dataclass(frozen=True)
class Cleaned:
    """What eliminating the conflicts took."""

    seconds: float
    """CPU, with this program's own limits."""
    cut: int
    """Pairs left out so."""
    paper_s: float
    """CPU, with the paper's five neighbours and limit of 0.1."""
    paper_cut: int
    """Pairs that it would leave out."""


@dataclass(frozen=True)
class Measured:
    """Everything that the tables are made of."""

    extent: Extent
    pairs: int
    demonstrated_s: float
    """Of flight."""
    cleaned: Cleaned
    settings: Mapping[str, Mapping[str, Any]]
    """Of the learners."""
    costs: Mapping[str, Costs]
    """Of every policy."""
    searches: Mapping[str, Search]
    pilots: Mapping[str, Pilot]
    compared: Mapping[float, Comparison]
    """By density."""
    crossings: Mapping[str, tuple[Crossing, ...]]
    """Of what was flown alone."""
    step_s: float
    """CPU seconds of one decision step of one field, of many at once, with nobody perceiving."""


def measure(
    scenes: Mapping[float, Scene],
    pairs: Pairs,
    extent: Extent,
    *,
    n_jobs: int,
    progress: Progress,
) -> Measured:
    """Everything of the case study, from `pairs` perceived through PERCEPTION.

    `scenes` are the asteroid field by density. CPU times are of whichever machine did the work.
    """
    place = scenes[extent.at]
    progress(0.0, "Cleaning and fitting")
    cleaning, cleaned = _clean(pairs, place, extent.repeats)
    policies: dict[str, Policy] = {}
    found: dict[str, Costs] = {}
    for name, (learner, settings) in LEARNERS.items():
        fit_policy(pairs, place, PERCEPTION, learner, {**settings})  # libraries load slowly
        start = time.process_time()
        policy = fit_policy(pairs, place, PERCEPTION, learner, settings, cleaning=cleaning)
        made_s = time.process_time() - start
        policies[name] = policy
        found[name] = costs(policy, pairs.states, made_s, extent.repeats)
    progress(0.1, "Searching by PEGASUS")
    searches = _search(place, extent, n_jobs, progress)
    for name, search in searches.items():
        policies[name] = search.policy
        made_s = search.rounds[-1].cpu_s
        found[name] = costs(search.policy, pairs.states, made_s, extent.repeats)
    pilots: dict[str, Pilot] = {
        "straight flight": find_pilot("straight"),
        "scripted human": find_pilot(DEMONSTRATOR),
        **{name: PolicyPilot(policy) for name, policy in policies.items()},
        ASTAR: AStarPilot(),
    }
    compared = {}
    for number, density in enumerate(extent.densities):

        def told(share: float, doing: str, number: int = number, density: float = density) -> None:
            done = (number + share) / len(extent.densities)
            progress(0.5 + 0.4 * done, f"NH {density:g}, {doing}")

        compared[density] = evaluate(
            scenes[density],
            pilots,
            worlds=extent.worlds,
            seed=extent.fields_seed,
            n_jobs=n_jobs,
            chunk=25,
            measure_time=False,
            progress=told,
        )
    progress(0.9, "Timing decisions")
    crossings = _cross(place, {name: pilots[name] for name in (*FLOWN, *searches)}, extent, n_jobs)
    progress(1.0, "Measured")
    return Measured(
        extent=extent,
        pairs=len(pairs),
        demonstrated_s=len(pairs) * place.dt_s,
        cleaned=cleaned,
        settings={name: policies[name].settings for name in LEARNERS},
        costs=found,
        searches=searches,
        pilots=pilots,
        compared=compared,
        crossings=crossings,
        step_s=_step_s(place, extent),
    )


def _clean(pairs: Pairs, scene: Scene, repeats: int) -> tuple[Cleaning, Cleaned]:
    span = scene.action.high - scene.action.low
    ours, theirs = [], []
    for _ in range(repeats + 1):
        start = time.process_time()
        cleaning = clean_pairs(pairs, scene, PERCEPTION)
        ours.append(time.process_time() - start)
        start = time.process_time()
        paper = ConflictEliminator(5, 0.1, span).fit(pairs.states, pairs.actions)
        theirs.append(time.process_time() - start)
    cut = int(cleaning.conflicts.sum()), int(paper.conflict_mask_.sum())
    middle = (float(np.median(spent[1:])) for spent in (ours, theirs))
    return cleaning, Cleaned(next(middle), cut[0], next(middle), cut[1])


def _search(scene: Scene, extent: Extent, n_jobs: int, progress: Progress) -> dict[str, Search]:
    run = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    done = run(joblib.delayed(_found)(scene, settings) for settings in extent.searches)
    searches = {}
    for number, (settings, search) in enumerate(zip(extent.searches, done, strict=True), start=1):
        searches[f"PEGASUS, {settings.optimiser}"] = search
        progress(0.1 + 0.4 * number / len(extent.searches), "Searching by PEGASUS")
    return searches


def _found(scene: Scene, settings: Pegasus) -> Search:
    rounds: list[Round] = []
    policy = settings.search(scene, PERCEPTION, watch=rounds.append)
    return Search(policy, tuple(rounds))


def _cross(
    scene: Scene, pilots: Mapping[str, Pilot], extent: Extent, n_jobs: int
) -> dict[str, tuple[Crossing, ...]]:
    seeds = world_seeds(extent.fields_seed, extent.timed)
    tasks = [(name, seed) for name in pilots for seed in seeds]
    done = joblib.Parallel(n_jobs=n_jobs)(
        joblib.delayed(cross)(scene, pilots[name], seed) for name, seed in tasks
    )
    return {
        name: tuple(one for (whose, _), one in zip(tasks, done, strict=True) if whose == name)
        for name in pilots
    }


def _step_s(scene: Scene, extent: Extent) -> float:
    seeds = world_seeds(extent.fields_seed, 100)
    start = scene.worlds(seeds)
    began = time.process_time()
    flown = roll_out(scene, find_pilot("straight"), seeds, start=start)
    return (time.process_time() - began) / int(flown.steps.sum())
