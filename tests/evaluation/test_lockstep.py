"""Worlds flown in step by compiled code: bit for bit what a rollout gives, world by world."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest

from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.flight import Logbook
from evastudio.evaluation.lockstep import TOGETHER, fly_in_step, goes_in_step
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.learner import Learner
from evastudio.learning.policy import Policy
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.pilots.straight import StraightPilot
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.spaces import Array

Kind = Callable[..., Scene]


class Plainly(PolicyPilot):
    """The same pilot, of another type, so that it is rolled out."""


@pytest.fixture(scope="module")
def shown(asteroids: Kind) -> tuple[Array, Array]:
    """States and actions of a scripted demonstrator."""
    scene = asteroids(density=4.0)
    log = Logbook(scene)
    roll_out(scene, find_pilot("scripted:human"), world_seeds(9, 6), watcher=log)
    view = scene.perception()
    seen = [(view.perceive(flight.moments), flight.actions) for flight in log.flights()]
    states = np.concatenate([percept.states for percept, _ in seen])
    own = [view.to_own(percept.frame, actions) for percept, actions in seen]
    return states, np.concatenate(own)


def policy_of(scene: Scene, learner: Learner, perception: str = "canonical") -> Policy:
    view = scene.perception(perception)
    return Policy(learner, scene.identity(), perception, view.state, scene.action, 1, "")


LEARNERS: dict[str, Callable[[], Learner]] = {
    "k-NN": lambda: KNNPolicy(5, "distance"),
    "compact SVR": lambda: SVRPolicy(bases=64),
}


def wild(actions: Array) -> Array:
    """Actions far beyond the limits, which lead out of the corridor."""
    return np.random.default_rng(3).normal(0.06, 0.5, actions.shape)


@pytest.mark.parametrize("learner", LEARNERS)
@pytest.mark.parametrize(
    ("options", "manner", "limit_s", "endings"),
    [
        ({"density": 4.0}, None, 90.0, {"crossed"}),
        ({"density": 10.0, "half_width": 45.0}, None, 90.0, {"crossed", "hit"}),
        ({"density": 0.1, "half_width": 30.0}, wild, 90.0, {"left"}),
        ({"density": 1.0, "half_width": 150.0}, wild, 12.0, {"late", "hit"}),
    ],
)
def test_every_moment_is_that_of_a_rollout(
    asteroids: Kind,
    shown: tuple[Array, Array],
    monkeypatch: pytest.MonkeyPatch,
    learner: str,
    options: dict[str, float],
    manner: Callable[[Array], Array] | None,
    limit_s: float,
    endings: set[str],
) -> None:
    scene = asteroids(**options)
    monkeypatch.setattr(sys.modules[type(scene).__module__], "TIME_LIMIT_S", limit_s)
    states, actions = shown
    fitted = LEARNERS[learner]().fit(states, actions if manner is None else manner(actions))
    pilot = PolicyPilot(policy_of(scene, fitted))
    seeds = world_seeds(7, 2 * TOGETHER + 1)
    log = Logbook(scene)
    plain = roll_out(scene, pilot, seeds, watcher=log)
    rollout, flights = fly_in_step(scene, pilot, seeds, max_steps=20_000)
    assert endings <= {scene.outcomes[outcome] for outcome in plain.outcomes}
    assert rollout.seeds == plain.seeds
    for name in ("outcomes", "steps", "turn"):
        assert np.array_equal(getattr(rollout, name), getattr(plain, name)), name
    for flight, other in zip(flights, log.flights(), strict=True):
        assert flight.moments.moving.keys() == other.moments.moving.keys()
        for name, array in other.moments.moving.items():
            assert np.array_equal(flight.moments[name], array), name
        for name, array in other.moments.fixed.items():
            assert np.array_equal(flight.moments.fixed[name][0], array[0]), name
        assert np.array_equal(flight.actions, other.actions)
        assert np.array_equal(flight.clearances, other.clearances)
    if manner is wild:
        assert max(np.abs(flight.moments["heading"]).max() for flight in flights) > 1.047


def test_an_evaluation_tells_nothing_of_the_way_it_was_made(
    asteroids: Kind, shown: tuple[Array, Array]
) -> None:
    scene = asteroids(density=6.0)
    policy = policy_of(scene, KNNPolicy().fit(*shown))
    assert goes_in_step(PolicyPilot(policy), scene)
    assert not goes_in_step(Plainly(policy), scene)
    ways = [
        evaluate(scene, {"it": pilot}, worlds=20, like="it", measure_time=False, chunk=chunk)
        for pilot, chunk in (
            (PolicyPilot(policy), 20),
            (PolicyPilot(policy), 7),
            (Plainly(policy), 20),
        )
    ]
    assert ways[0].to_json() == ways[1].to_json() == ways[2].to_json()


def test_it_stops_where_steps_run_out(asteroids: Kind, shown: tuple[Array, Array]) -> None:
    scene = asteroids()
    pilot = PolicyPilot(policy_of(scene, KNNPolicy().fit(*shown)))
    rollout, flights = fly_in_step(scene, pilot, world_seeds(1, 3), max_steps=5)
    assert list(rollout.outcomes) == [0, 0, 0]
    assert [len(flight.actions) for flight in flights] == [5, 5, 5]


def test_only_what_the_compiled_code_does_goes_in_step(
    asteroids: Kind, shown: tuple[Array, Array], tmp_path_factory: pytest.TempPathFactory
) -> None:
    scene = asteroids()
    knn = policy_of(scene, KNNPolicy().fit(*shown))
    assert goes_in_step(PolicyPilot(knn), scene)
    assert not goes_in_step(StraightPilot(), scene)
    drawn = policy_of(scene, SampledKNNPolicy().fit(*shown))
    assert not goes_in_step(PolicyPilot(drawn), scene)
    other = policy_of(scene, knn.learner, "paper")
    assert not goes_in_step(PolicyPilot(other), scene)
    text = sys.modules[type(scene).__module__].__dict__["__source__"]
    file = tmp_path_factory.mktemp("own") / "asteroids.py"
    file.write_text(text, encoding="utf-8")
    assert goes_in_step(PolicyPilot(knn), load_scene_file(file)())
    file = file.with_name("faster.py")
    file.write_text(text.replace("SPEED = 10.0", "SPEED = 12.0"), encoding="utf-8")
    assert not goes_in_step(PolicyPilot(knn), load_scene_file(file)())
