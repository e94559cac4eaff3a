"""What it costs to leave a moment out of what plays, until the next decision is made without it.

python -m benchmarks.forgetting            # 100,000 pairs; half a minute, also part of `make bench`
python -m benchmarks.forgetting --quick    # fewer, to see that it runs
"""

from __future__ import annotations

import copy
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from benchmarks.fields import DENSITY, demonstrated
from benchmarks.report import Part, commit, where_and_when
from evastudio.demonstrations.by_hand import mark_by_hand
from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.store import Store
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.fitting import fit_policy
from evastudio.learning.learner import Indices
from evastudio.learning.policy import Policy
from evastudio.live.correcting import leave_out
from evastudio.live.stage import Stage
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.why import Reasoner
from evastudio.workspace import shipped
from evastudio.world.loading import find_scene
from evastudio.world.scene import Scene

PAIRS = 100_000
TAKE = 500
SHOWN = 10_000
"""Pairs that are demonstrated; of more pairs the rest are these again, a little moved."""
SVR_PAIRS = 6_000
REPEATS = 31
AT_MOST_MS = 5.0


@dataclass(frozen=True)
class Cost:
    """CPU milliseconds of leaving one moment out, medians."""

    learner: str
    pairs: int
    found_ms: float
    """Finding the pair among those that the policy keeps."""
    left_out_ms: float
    """Taking it out, which for a k-NN is all that the stage waits for, and for an SVR another
    thread does."""
    told_ms: float
    """Telling anew what the present decision comes from."""
    anew_ms: float
    """Fitting the policy anew without it: what one would do instead."""

    @property
    def whole_ms(self) -> float:
        return self.found_ms + self.left_out_ms + self.told_ms


def paired(scene: Scene, count: int) -> Pairs:
    """So many pairs in takes of TAKE steps."""
    states, actions = demonstrated(scene, min(count, SHOWN))
    rng = np.random.default_rng(0)
    rows = np.arange(count) % len(states)
    again = (np.arange(count) >= len(states))[:, None]
    parts = []
    for shown in (states, actions):
        moved = rng.normal(0.0, 0.01, (count, shown.shape[1])) * shown.std(axis=0)
        parts.append(shown[rows] + again * moved)
    takes, steps = np.divmod(np.arange(count), TAKE)
    return Pairs(parts[0], parts[1], takes + 1, steps)


def milliseconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return 1e3 * (time.process_time() - start)


def forgetting(scene: Scene, learner: str, count: int, repeats: int) -> Cost:
    """Leave the nearest moment of the present decision out, `repeats` times, while it plays.

    Every time what is decided next is another action than before: else this raises.
    """
    pairs = paired(scene, count)
    policy = fit_policy(pairs, scene, None, learner)
    anew = milliseconds(lambda: fit_policy(pairs, scene, None, learner))
    pilot = PolicyPilot(policy, "playing")
    reasoner = Reasoner(pilot)
    stage, now = Stage(scene, 1, 0.0), 0.0
    stage.play(scene, pilot, 5, now, 0.0, reasoner)
    found: list[float] = []
    left: list[float] = []
    told: list[float] = []
    for _ in range(repeats):
        now += 0.4
        stage.advance(now, 0.0)
        why = stage.act.why()
        if why is None or why.moments is None:
            raise RuntimeError("The policy tells no reasons.")
        take, step = why.moments[0].tolist()
        looked = stage.run.reel.moment(stage.run.steps - 1)
        before, _ = pilot.act(scene, looked, {})
        times = [time.process_time()]
        holder, gone = reasoner.holder(take, step)
        times.append(time.process_time())
        _without(holder, gone)
        times.append(time.process_time())
        stage.rethink()
        times.append(time.process_time())
        for spent, (begin, end) in zip((found, left, told), pairwise(times), strict=True):
            spent.append(1e3 * (end - begin))
        after, _ = pilot.act(scene, looked, {})
        if np.array_equal(before, after) and learner == "knn":
            raise RuntimeError("The decision did not change.")
    middle = statistics.median
    return Cost(learner, count, middle(found), middle(left), middle(told), anew)


def _without(pilot: PolicyPilot, gone: Indices) -> None:
    """As `Correcting.forget` does."""
    policy: Policy = pilot.policy
    if policy.learner_name == "knn":
        leave_out(pilot, gone)
    else:
        pilot.policy = copy.deepcopy(policy).without(gone)


def marking(scene: Scene, count: int, repeats: int) -> float:
    """CPU milliseconds to write into the store, behind it, that one moment is left out."""
    with tempfile.TemporaryDirectory() as folder, Store(f"sqlite:///{folder}/store.db") as store:
        session = store.create_session(scene, "Many", "benchmark", 0.0)
        world = scene.worlds([1])
        view = scene.perception()
        moving = {name: np.repeat(array, TAKE, axis=0) for name, array in world.moving.items()}
        states, actions = np.zeros((TAKE, view.state.size)), np.zeros((TAKE, scene.action.size))
        for seed in range(count // TAKE):
            take = store.begin_take(session, scene, view.name, seed, "person", world.fixed, 0.0)
            store.append(take, 0, states, actions, moving)
            store.finish_take(take, None, 1.0)
        last = take
        spent = [
            milliseconds(lambda step=step: mark_by_hand(store, last, step, True, 2.0))
            for step in range(repeats)
        ]
    return statistics.median(spent)


def section(quick: bool) -> str:
    """What was measured, in Markdown."""
    began = time.monotonic()
    at = commit("evastudio", "benchmarks")
    ensure_compiled()
    scene = find_scene("asteroids", (shipped() / "scenes",))(density=DENSITY)
    many, some, repeats = (4000, 500, 5) if quick else (PAIRS, SVR_PAIRS, REPEATS)
    costs = [
        forgetting(scene, "knn", many, repeats),
        forgetting(scene, "svr", some, 1 if quick else 5),
    ]
    marked = marking(scene, many, 5)
    return "\n".join(
        [
            "# Leaving a moment out of what plays",
            "",
            where_and_when(at, "make bench", time.monotonic() - began),
            f"- A stage plays a policy in the asteroid field; the moment nearest to its present "
            f"decision is left out, {repeats} times for k-NN. CPU time, medians. Every time the "
            "next decision of the k-NN is another one.",
            "- Of a k-NN the stage waits for taking out and telling; of an SVR, which is fitted on "
            "from where it was, for telling alone.",
            "",
            "| learner | pairs | find it | take it out | tell anew why | together | fit anew |",
            "|---|---:|---:|---:|---:|---:|---:|",
            *(
                f"| {one.learner} | {one.pairs:,} | {one.found_ms:.2f} ms | "
                f"{one.left_out_ms:.2f} ms | {one.told_ms:.2f} ms | {one.whole_ms:.2f} ms | "
                f"{one.anew_ms:.0f} ms |"
                for one in costs
            ),
            "",
            f"- At most {AT_MOST_MS:g} ms are asked of 100,000 pairs: the k-NN takes "
            f"{costs[0].whole_ms:.2f} ms of {costs[0].pairs:,}.",
            f"- Behind it, on another thread, the store is told not to fit it any more: "
            f"{marked:.1f} ms of a session of {many:,} pairs.",
        ]
    )


PART = Part("forgetting", section)

if __name__ == "__main__":
    PART.main(__doc__)
