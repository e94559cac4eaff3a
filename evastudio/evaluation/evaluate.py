"""Evaluation: pilots fly the same seeded worlds, and what became of them is counted."""

from __future__ import annotations

import functools
import inspect
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

import joblib
import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.evaluation.interval import wilson_interval
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import Pilot, Rollout, roll_out
from evastudio.world.scene import Scene, world_seeds

Progress = Callable[[float, str], None]
"""Told the share done, 0 to 1, and what is being done."""

CHUNK = 100
"""Worlds flown in one batch. Results do not depend on it."""
MAX_STEPS = 20_000


@dataclass(frozen=True)
class Evaluation:
    """How one pilot fared."""

    pilot: str
    worlds: int
    crossed: int
    """Worlds that ended with one of the scene's successes."""
    outcomes: Mapping[str, int]
    """How many worlds ended in each way; 'running' where none came in time."""
    mean_time_s: float | None
    """Of the worlds that ended well; None where none did."""
    median_time_s: float | None
    turn: float
    """Mean change of the action from one decision to the next, as a share of its range: lower is
    smoother."""
    decision_us: float | None = None
    """Median time of one decision for one world; it depends on the machine and its load."""

    @property
    def crossing_rate(self) -> float:
        return self.crossed / self.worlds

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson 95 % interval of the crossing rate."""
        return wilson_interval(self.crossed, self.worlds)

    def to_json(self) -> dict[str, Any]:
        """The figures, as JSON holds them."""
        return {
            "worlds": self.worlds,
            "crossed": self.crossed,
            "crossing_rate": self.crossing_rate,
            "interval": list(self.interval),
            "outcomes": dict(self.outcomes),
            "mean_time_s": self.mean_time_s,
            "median_time_s": self.median_time_s,
            "turn": self.turn,
            "decision_us": self.decision_us,
        }


@dataclass(frozen=True)
class Comparison:
    """Several pilots on the same worlds."""

    scene: Mapping[str, Any]
    """Identity of the scene: name, version, options."""
    seed: int
    worlds: int
    pilots: Mapping[str, Evaluation]

    def to_json(self) -> dict[str, Any]:
        """The figures, as JSON holds them; all but `decision_us` repeat exactly."""
        return {
            "scene": dict(self.scene),
            "seed": self.seed,
            "worlds": self.worlds,
            "pilots": {name: one.to_json() for name, one in self.pilots.items()},
        }


def evaluate(
    scene: Scene,
    pilots: Mapping[str, Pilot],
    *,
    worlds: int = 1000,
    seed: int = 0,
    n_jobs: int = 1,
    chunk: int = CHUNK,
    max_steps: int = MAX_STEPS,
    measure_time: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Fly every one of `pilots` through the same `worlds` worlds that follow from `seed`.

    The outcome does not depend on `n_jobs` or `chunk`. On a cluster, choose joblib's backend
    around this call and pass `n_jobs=-1`. Raises InvalidInputError for fewer than one world or
    no pilot.
    """
    if not isinstance(worlds, int) or worlds < 1:
        raise InvalidInputError(f"{worlds!r} worlds were asked for; choose at least 1.")
    if not pilots:
        raise InvalidInputError("There is nothing to evaluate: name at least one pilot.")
    seeds = world_seeds(seed, worlds)
    parts = [seeds[start : start + chunk] for start in range(0, worlds, chunk)]
    tasks = [(name, part) for name in pilots for part in parts]
    sent = scene if n_jobs == 1 else _for_workers(scene)
    run = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    results = run(joblib.delayed(_fly)(sent, pilots[name], part, max_steps) for name, part in tasks)
    flown: dict[str, list[Rollout]] = {name: [] for name in pilots}
    for done, ((name, _), rollout) in enumerate(zip(tasks, results, strict=True), start=1):
        flown[name].append(rollout)
        if progress is not None:
            progress(done / len(tasks), f"{name}: {len(flown[name])} of {len(parts)}")
    return Comparison(
        scene=scene.identity(),
        seed=seed,
        worlds=worlds,
        pilots={
            name: summarize(
                scene,
                name,
                rollouts,
                decision_us(scene, pilots[name], seeds[0]) if measure_time else None,
            )
            for name, rollouts in flown.items()
        },
    )


def summarize(
    scene: Scene, name: str, rollouts: Sequence[Rollout], decision_us: float | None = None
) -> Evaluation:
    """The figures of one pilot from its `rollouts`."""
    outcomes = np.concatenate([rollout.outcomes for rollout in rollouts])
    steps = np.concatenate([rollout.steps for rollout in rollouts])
    turn = np.concatenate([rollout.turn for rollout in rollouts])
    good = np.isin(outcomes, [scene.outcomes.index(name) for name in scene.successes])
    times = steps[good] * scene.dt_s
    return Evaluation(
        pilot=name,
        worlds=len(outcomes),
        crossed=int(good.sum()),
        outcomes={
            outcome: int((outcomes == index).sum()) for index, outcome in enumerate(scene.outcomes)
        },
        mean_time_s=float(times.mean()) if len(times) else None,
        median_time_s=float(np.median(times)) if len(times) else None,
        turn=float(turn.mean()),
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
    snapshot = scene.worlds([seed])
    memory = pilot.begin(scene, [seed])
    spent = []
    for _ in range(decisions):
        start = clock()
        actions, memory = pilot.act(scene, snapshot, memory)
        spent.append(clock() - start)
        snapshot = scene.step(snapshot, scene.action.clip(actions))
        if scene.outcome(snapshot)[0] != 0:
            snapshot = scene.worlds([seed])
            memory = pilot.begin(scene, [seed])
    return statistics.median(spent) * 1e6


@dataclass(frozen=True)
class _SceneFile:
    """How a worker process gets at a scene that it cannot import by name: from its file."""

    path: Path
    values: Mapping[str, float]

    def load(self) -> Scene:
        return _load_once(self.path)(**self.values)


_load_once = functools.cache(load_scene_file)


def _for_workers(scene: Scene) -> Scene | _SceneFile:
    package = type(scene).__module__.partition(".")[0]
    if PathFinder.find_spec(package) is not None:
        return scene
    return _SceneFile(Path(inspect.getfile(type(scene))), dict(scene.values))


def _fly(scene: Scene | _SceneFile, pilot: Pilot, seeds: Sequence[int], max_steps: int) -> Rollout:
    if isinstance(scene, _SceneFile):
        scene = scene.load()
    return roll_out(scene, pilot, seeds, max_steps=max_steps)
