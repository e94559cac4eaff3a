"""Practice through a scene's Gymnasium environment, by Stable-Baselines3 itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evastudio.learning.policy_files import load_policy, save_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.ppo import PPO, Lesson
from evastudio.pilots.scripted import find_pilot
from evastudio.pilots.stable_baselines import Worlds
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.vector_environment import SceneVectorEnvironment

Step = tuple[Any, Any, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class BrokenOff(SceneVectorEnvironment):
    """Its worlds are broken off where they would have ended."""

    def step(self, actions: Any) -> Step:
        states, rewards, terminated, truncated, infos = super().step(actions)
        return states, rewards, truncated, terminated, infos


@pytest.mark.parametrize("kind", [SceneVectorEnvironment, BrokenOff])
def test_it_practises_in_the_worlds_of_the_environment(
    kind: type[SceneVectorEnvironment], asteroids: Callable[..., Scene]
) -> None:
    scene = asteroids(density=10.0, half_width=30.0)
    there = SceneVectorEnvironment(3, scene, "paper")
    worlds = Worlds(kind(3, scene, "paper"), seed=4, calm=0.25)
    assert np.array_equal(worlds.reset(), there.reset(seed=4)[0].astype(np.float32))
    rng = np.random.default_rng(0)
    ends = 0
    while ends < 3:
        shares = rng.uniform(-2.0, 2.0, (3, 2)).astype(np.float32)
        states, rewards, ended, infos = worlds.step(shares)
        seen, earned, over, _, told = there.step(shares.astype(np.float64) * scene.action.high)
        assert np.array_equal(states, seen.astype(np.float32))
        cost = 0.25 * (np.clip(shares, -1.0, 1.0) ** 2).sum(axis=1)
        assert rewards == pytest.approx(earned - cost, abs=1e-6)
        assert np.array_equal(ended, over)
        for world, info in enumerate(infos):
            assert bool(info) == over[world]
            if info:
                ends += 1
                last = told["final_obs"][world].astype(np.float32)
                assert np.array_equal(info["terminal_observation"], last)
                assert info["TimeLimit.truncated"] == (kind is BrokenOff)


def test_it_learns_to_cross_and_its_file_decides_the_same(
    tmp_path: Path, asteroids: Callable[..., Scene]
) -> None:
    scene = asteroids(density=4.0, half_width=100.0)
    fields = world_seeds(31, 50)

    def crossed(pilot: Pilot) -> float:
        flown = roll_out(scene, pilot, fields)
        return float((flown.outcomes == scene.outcomes.index("crossed")).mean())

    heard: list[Lesson] = []
    policy = PPO(decisions=16_384, worlds=32, between=64, batch=256, seed=1).learn(
        scene, "canonical", watch=heard.append
    )
    assert [lesson.decisions for lesson in heard] == list(range(2048, 16_385, 2048))
    assert crossed(find_pilot("straight")) < 0.1
    assert crossed(PolicyPilot(policy)) > 0.5

    path = tmp_path / "practised.safetensors"
    save_policy(policy, path)
    again = load_policy(path)
    states = SceneVectorEnvironment(64, scene, "canonical").reset(seed=1)[0]
    assert np.array_equal(again.learner.decide(states), policy.learner.decide(states))
    assert again.extra["ppo"]["decisions"] == 16_384


def test_practice_follows_from_its_seed(asteroids: Callable[..., Scene]) -> None:
    def practised(seed: int) -> NDArray[np.float64]:
        settings = PPO(decisions=512, worlds=8, between=32, batch=64, seed=seed)
        return settings.learn(asteroids(), "canonical").learner.decide(np.eye(6))

    assert np.array_equal(practised(1), practised(1))
    assert not np.array_equal(practised(1), practised(2))
