"""Evaluation: pilots fly the same seeded worlds, and what became of them is counted."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import joblib
import numpy as np

from evastudio.errors import InvalidInputError, not_found
from evastudio.evaluation.blaming import blaming
from evastudio.evaluation.cluster import once
from evastudio.evaluation.flight import Logbook, figures_of, path_features
from evastudio.evaluation.likeness import inhomogeneity, thinned
from evastudio.evaluation.lockstep import fly_in_step, goes_in_step
from evastudio.evaluation.results import Comparison, Evaluation
from evastudio.world.rollout import Pilot, Rollout, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.spaces import Array

Progress = Callable[[float, str], None]
"""Told the share done, 0 to 1, and what is being done."""

CHUNK = 100
"""Worlds flown in one batch. Results do not depend on it."""
MAX_STEPS = 20_000
KEPT = 32
"""Moments of each world that are kept for telling how alike two pilots move."""


@dataclass(frozen=True)
class Flown:
    """What became of a batch of worlds."""

    rollout: Rollout
    figures: Mapping[str, Array]
    """One for each world, shape (worlds,)."""
    features: Array
    """`path_features` of KEPT moments of each world, one below the other."""


@dataclass(frozen=True)
class Shown:
    """How somebody moved, for the pilots to be like."""

    name: str
    """Whose moving it is, for people."""
    features: Array
    """`path_features` of it, moment by moment."""


def evaluate(
    scene: Scene,
    pilots: Mapping[str, Pilot],
    *,
    worlds: int = 1000,
    seed: int = 0,
    like: str | Shown | None = None,
    n_jobs: int = 1,
    chunk: int = CHUNK,
    max_steps: int = MAX_STEPS,
    measure_time: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Fly every one of `pilots` through the same `worlds` worlds that follow from `seed`.

    `like` names the pilot, one of them, that the others should move like, or is what somebody
    showed. The outcome does not
    depend on `n_jobs` or `chunk`. On a cluster, choose joblib's backend around this call and pass
    `n_jobs=-1`. Raises InvalidInputError for fewer than one world or no pilot, NotFoundError where
    `like` is none of them.
    """
    if not isinstance(worlds, int) or worlds < 1:
        raise InvalidInputError(f"{worlds!r} worlds were asked for; choose at least 1.")
    if not pilots:
        raise InvalidInputError("There is nothing to evaluate: name at least one pilot.")
    if isinstance(like, str) and like not in pilots:
        raise not_found("pilot", like, pilots, "among those evaluated")
    seeds = world_seeds(seed, worlds)
    parts = [seeds[start : start + chunk] for start in range(0, worlds, chunk)]
    tasks = [(name, part) for name in pilots for part in parts]
    run = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    place, sent = once(scene), {name: once(pilot) for name, pilot in pilots.items()}
    results = run(
        joblib.delayed(fly)(place, sent[name], part, max_steps, name) for name, part in tasks
    )
    flown: dict[str, list[Flown]] = {name: [] for name in pilots}
    for done, ((name, _), part) in enumerate(zip(tasks, results, strict=True), start=1):
        flown[name].append(part)
        if progress is not None:
            progress(done / len(tasks), f"{name}: {len(flown[name])} of {len(parts)}")
    shown = Shown(like, _features(flown[like])) if isinstance(like, str) else like
    chance = None if shown is None else _chance(shown)
    evaluations = {}
    for name, done_parts in flown.items():
        unlike = None
        if shown is not None:
            unlike = chance if name == like else _unlike(_features(done_parts), shown.features)
        evaluations[name] = gather(
            scene,
            name,
            done_parts,
            unlike=unlike,
            decision_us=decision_us(scene, pilots[name], seeds[0]) if measure_time else None,
        )
    return Comparison(
        scene=scene.identity(),
        seed=seed,
        worlds=worlds,
        like=None if shown is None else shown.name,
        chance=chance,
        pilots=evaluations,
    )


def gather(
    scene: Scene,
    name: str,
    parts: Sequence[Flown],
    *,
    unlike: float | None = None,
    decision_us: float | None = None,
) -> Evaluation:
    """The result of one pilot from its `parts`, in the order of the worlds."""
    outcomes = np.concatenate([part.rollout.outcomes for part in parts])
    steps = np.concatenate([part.rollout.steps for part in parts])
    good = np.isin(outcomes, [scene.outcomes.index(name) for name in scene.successes])
    names = dict.fromkeys(name for part in parts for name in part.figures)
    own = {
        name: np.concatenate(
            [part.figures.get(name, np.full(len(part.rollout.steps), np.nan)) for part in parts]
        )
        for name in names
    }
    return Evaluation(
        pilot=name,
        endings=scene.outcomes,
        outcomes=outcomes,
        succeeded=good,
        figures={
            "time_s": np.where(good, steps * scene.dt_s, np.nan),
            "turn": np.concatenate([part.rollout.turn for part in parts]),
            **own,
        },
        unlike=unlike,
        decision_us=decision_us,
    )


def decision_us(
    scene: Scene,
    pilot: Pilot,
    seed: int,
    *,
    decisions: int = 60,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Median microseconds of one decision, perception included, for one world."""
    spent = []
    with blaming(scene, pilot.name):
        snapshot = scene.worlds([seed])
        memory = pilot.begin(scene, [seed])
        for _ in range(decisions):
            start = clock()
            actions, memory = pilot.act(scene, snapshot, memory)
            spent.append(clock() - start)
            snapshot = scene.step(snapshot, scene.action.clip(actions))
            if scene.outcome(snapshot)[0] != 0:
                snapshot = scene.worlds([seed])
                memory = pilot.begin(scene, [seed])
    return statistics.median(spent) * 1e6


def fly(scene: Scene, pilot: Pilot, seeds: Sequence[int], max_steps: int, name: str) -> Flown:
    """What becomes of the worlds of `seeds`: one task of an evaluation.

    Raises InvalidInputError where the scene's own code fails; `name` is what the pilot is called.
    """
    with blaming(scene, name):
        if goes_in_step(pilot, scene):
            rollout, flights = fly_in_step(scene, pilot, seeds, max_steps=max_steps)
        else:
            log = Logbook(scene)
            rollout = roll_out(scene, pilot, seeds, max_steps=max_steps, watcher=log)
            flights = log.flights()
        figures = [figures_of(scene, flight) for flight in flights]
        features = [thinned(path_features(scene, flight), KEPT) for flight in flights]
        return Flown(
            rollout,
            {figure: np.array([one[figure] for one in figures]) for figure in figures[0]},
            np.concatenate(features),
        )


def _features(parts: Sequence[Flown]) -> Array:
    return np.concatenate([part.features for part in parts])


def _chance(shown: Shown) -> float | None:
    """How far one half of what was shown is from the other."""
    half = len(shown.features) // 2
    return _unlike(shown.features[:half], shown.features[half:])


def _unlike(ours: Array, shown: Array) -> float | None:
    return inhomogeneity(ours, shown) if min(len(ours), len(shown)) else None
