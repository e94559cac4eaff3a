"""How fast policies cross asteroid fields, beside what people would write: part of `make bench`.

python -m benchmarks.fields            # 10,000 fields, some minutes
python -m benchmarks.fields --quick    # a few, to see that it runs
"""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass

import gymnasium
import numpy as np
from sklearn.neighbors import KNeighborsRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

import evastudio  # noqa: F401 - registers the scenes
from benchmarks.report import Part, commit, where_and_when
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.flight import Logbook
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.learner import Learner
from evastudio.learning.policy import Policy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import shipped
from evastudio.world.loading import find_scene
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.spaces import Array

FIELDS = 10_000
PAIRS = 6_000
K = 5
DENSITY = 4.0
SEED = 1
AT_MOST_S = 60.0
AT_LEAST = 10.0


class Plainly(PolicyPilot):
    """The same policy, rolled out and not flown in step."""


@dataclass(frozen=True)
class Flown:
    """What some fields took."""

    fields: int
    cpu_s: float
    crossed: int
    steps: float
    """Mean decisions of those that crossed."""

    @property
    def field_ms(self) -> float:
        return 1e3 * self.cpu_s / self.fields


def demonstrated(scene: Scene, pairs: int) -> tuple[Array, Array]:
    """States and actions of the scripted `human`, in the ship's own frame."""
    log = Logbook(scene)
    roll_out(scene, find_pilot("scripted:human"), world_seeds(9, pairs // 500 + 1), watcher=log)
    view = scene.perception()
    seen = [(view.perceive(flight.moments), flight.actions) for flight in log.flights()]
    states = np.concatenate([percept.states for percept, _ in seen])
    own = np.concatenate([view.to_own(percept.frame, actions) for percept, actions in seen])
    return states[:pairs], own[:pairs]


def flown(scene: Scene, pilot: PolicyPilot, fields: int) -> Flown:
    """Evaluate `pilot`: the worlds made, flown, and every figure of them."""
    start = time.process_time()
    result = evaluate(scene, {"it": pilot}, worlds=fields, seed=SEED, measure_time=False)
    result.to_json()
    spent = time.process_time() - start
    one = result.pilots["it"]
    steps = (one.mean("time_s") or 0.0) / scene.dt_s
    return Flown(fields, spent, int(one.succeeded.sum()), steps)


def looped(states: Array, actions: Array, fields: int) -> Flown:
    """The same worlds as most would do it: an environment, a regressor, one decision at a time."""
    regressor = make_pipeline(StandardScaler(), KNeighborsRegressor(K)).fit(states, actions)
    environment = gymnasium.make("evastudio/Asteroids-v0", density=DENSITY).unwrapped
    taken = []
    start = time.process_time()
    for seed in world_seeds(SEED, fields):
        state, _ = environment.reset(seed=seed)
        ended, steps = False, 0
        while not ended:
            state, _, ended, _, told = environment.step(regressor.predict(state[None])[0])
            steps += 1
        if told["outcome"] == "crossed":
            taken.append(steps)
    spent = time.process_time() - start
    return Flown(fields, spent, len(taken), statistics.mean(taken) if taken else 0.0)


def measured(quick: bool) -> list[tuple[str, Flown]]:
    """Ours and theirs, in one process, one after the other."""
    ensure_compiled()
    scene = find_scene("asteroids", (shipped() / "scenes",))(density=DENSITY)
    states, actions = demonstrated(scene, 1000 if quick else PAIRS)

    def policy(learner: Learner) -> Policy:
        view = scene.perception()
        fitted = learner.fit(states, actions)  # type: ignore[attr-defined]
        space = scene.action
        return Policy(fitted, scene.identity(), view.name, view.state, space, len(states), "")

    knn, svr = policy(KNNPolicy(K)), policy(SVRPolicy(bases=256))
    many, some, few = (64, 32, 1) if quick else (FIELDS, 1000, 8)
    flown(scene, PolicyPilot(knn), 1)  # the first loads the compiled code
    return [
        (f"k-NN, {K} of {len(states):,} pairs, in step", flown(scene, PolicyPilot(knn), many)),
        ("SVR, 256 bases, in step", flown(scene, PolicyPilot(svr), some)),
        ("the same k-NN, rolled out", flown(scene, Plainly(knn), some)),
        ("loop over the Gymnasium environment, scikit-learn", looped(states, actions, few)),
    ]


def section(quick: bool) -> str:
    """What was measured, in Markdown."""
    began = time.monotonic()
    at = commit("evastudio", "scenes", "benchmarks")
    rows = measured(quick)
    ours, theirs = rows[0][1], rows[-1][1]
    whole = ours.cpu_s * FIELDS / ours.fields
    return "\n".join(
        [
            "## Crossing asteroid fields",
            "",
            where_and_when(at, "make bench", time.monotonic() - began),
            f"- Fields of density {DENSITY:g}. Ours is the whole of an evaluation: worlds are made "
            "and flown, with every figure of every flight and its interval. The loop makes and "
            "flies worlds with `gymnasium.make` and `KNeighborsRegressor`, one decision at a "
            "time, and measures nothing; it flies the first few of the same fields. CPU time of "
            "one process.",
            "- In step and rolled out give the same bits, so they cross the same fields.",
            "",
            "| what | fields | crossed | decisions each | CPU | CPU a field | the loop takes |",
            "|---|---:|---:|---:|---:|---:|---:|",
            *(
                f"| {what} | {one.fields:,} | {one.crossed:,} | {one.steps:.0f} | "
                f"{one.cpu_s:.1f} s | {one.field_ms:.2f} ms | "
                f"{theirs.field_ms / one.field_ms:.0f}x |"
                for what, one in rows
            ),
            "",
            f"{FIELDS:,} fields by k-NN: {whole:.0f} s CPU (at most {AT_MOST_S:g}); the loop takes "
            f"{theirs.field_ms / ours.field_ms:.0f} times as long a field (at least "
            f"{AT_LEAST:g}).",
        ]
    )


PART = Part("fields", section)

if __name__ == "__main__":
    PART.main(__doc__)
