"""The crowds that are compared: who walks, in which worlds, with and without the guard.

What `crowd.py` measures; nothing here is run by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import joblib
import numpy as np

from benchmarks.crowds.fleeing import LEARNERS, Fled, flee
from benchmarks.crowds.walking import (
    CROWD,
    SCENE,
    Quantised,
    Redrawing,
    Walked,
    demonstrated,
    walk,
)
from benchmarks.report import ROOT
from evastudio.learning.fitting import fit_policy
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.policy_files import load_policy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import Pilot
from evastudio.world.spaces import Array

PEOPLE, SIDE, MINUTES = 200, 40, 10.0
WORLDS = (31, 32, 33, 34, 35)
"""Seeds of the worlds, and of the demonstrations that the policies walking there are from."""
SHOWN = 16.0
"""Minutes of demonstration, as the shipped policies had."""
STYLES = ("hurried", "shy")
LEARNED_MINUTES = 5.0
"""For policies that are not shipped."""
FEWER_MINUTES = 3.0
"""At other densities than that of `PEOPLE`."""
DENSITIES = {5.0: 80, 12.5: 200, 20.0: 320, 30.0: 480}
"""Share of the cells that are taken, %, and people."""
PERCEPTIONS = ("paper", "own", "ahead", "paths")
Result = tuple[str, bool, int, list[Walked]]
WAYS = ("counted votes", "sampled votes", "k-NN of moves, quantised")


@dataclass(frozen=True)
class Row:
    """One crowd in all worlds."""

    name: str
    guard: bool
    people: int
    walked: tuple[Walked, ...]
    """One for each world."""

    def of(self, field: str) -> Array:
        """A figure in every world, (worlds,)."""
        return np.array([getattr(one, field) for one in self.walked])


def shipped(name: str) -> Pilot:
    """A scripted demonstrator, or a shipped policy."""
    if name.startswith("scripted:"):
        return find_pilot(name)
    return PolicyPilot(load_policy(ROOT / "policies" / f"{name}.safetensors"), name)


def learned(style: str, seed: int, minutes: float) -> dict[str, Pilot]:
    """Every way of learning one demonstration of the scripted `style`."""
    scene, demonstrator = CROWD(), find_pilot(f"scripted:{style}")
    shown = demonstrated(demonstrator, seed, minutes, still=True)
    pilots: dict[str, Pilot] = {}
    for name in PERCEPTIONS:
        pairs = shown[name]
        moves = SCENE.MOVES[pairs.actions[:, 0].astype(int)]
        drawn = PolicyPilot(fit_policy(pairs, scene, name, "sampled-voting"))
        averaged = KNNPolicy(5, "uniform").fit(pairs.states, moves)
        counted = PolicyPilot(fit_policy(pairs, scene, name, "voting"))
        ways = (counted, drawn, Quantised(averaged, name))
        pilots |= {f"`{name}`, {way}": pilot for way, pilot in zip(WAYS, ways, strict=True)}
    machine = SVRPolicy().fit(shown["paths"].states, moves)
    pilots["`paths`, SVR of moves, quantised"] = Quantised(machine, "paths")
    pilots["`paths`, sampled votes, drawn again where in vain"] = Redrawing(drawn)
    moving = demonstrated(demonstrator, seed, minutes, still=False)["paths"]
    pilots["`paths`, sampled votes, shown among people who walk"] = PolicyPilot(
        fit_policy(moving, scene, "paths", "sampled-voting")
    )
    return pilots


def walk_learned(style: str, seed: int, minutes: float, shown: float) -> list[Result]:
    """All that was learned from one demonstration of `shown` minutes, in one world."""
    return [
        (f"{style}: {name}", guard, PEOPLE, walk(pilot, PEOPLE, SIDE, minutes, [seed], guard))
        for name, pilot in learned(style, seed, shown).items()
        for guard in (False, True)
    ]


def walk_shipped(name: str, people: int, seeds: Sequence[int], minutes: float) -> list[Result]:
    """One shipped policy or demonstrator in all worlds."""
    pilot = shipped(name)
    return [
        (name, guard, people, walk(pilot, people, SIDE, minutes, seeds, guard))
        for guard in (False, True)
    ]


def walk_all(seeds: Sequence[int], quick: bool, jobs: int) -> list[Row]:
    """Every crowd, in the order of the tables."""
    times = (1.0, 1.0, 1.0, 4.0) if quick else (MINUTES, FEWER_MINUTES, LEARNED_MINUTES, SHOWN)
    whole, fewer, learning, shown = times
    tasks = [joblib.delayed(walk_learned)(STYLES[0], seed, learning, shown) for seed in seeds]
    tasks += [
        joblib.delayed(walk_shipped)(
            f"{kind}{style}", people, seeds, whole if people == PEOPLE else fewer
        )
        for style in STYLES
        for kind in ("scripted:", "crowd-")
        for people in DENSITIES.values()
    ]
    found: dict[tuple[str, bool, int], list[Walked]] = {}
    for results in joblib.Parallel(n_jobs=jobs)(tasks):
        for name, guard, people, walked in results:
            found.setdefault((name, guard, people), []).extend(walked)
    return [Row(*key, tuple(walked)) for key, walked in found.items()]


def flee_all(seeds: Sequence[int], jobs: int) -> dict[str, list[Fled]]:
    """How every learner fled in every world."""
    walker = shipped("crowd-hurried")
    tasks = [(name, seed) for name in LEARNERS for seed in seeds]
    fled: dict[str, list[Fled]] = {}
    run = joblib.Parallel(n_jobs=jobs)
    results = run(
        joblib.delayed(flee)(walker, *LEARNERS[name], seed, PEOPLE) for name, seed in tasks
    )
    for (name, _), one in zip(tasks, results, strict=True):
        fled.setdefault(name, []).append(one)
    return fled
