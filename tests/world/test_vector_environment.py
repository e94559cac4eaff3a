"""Scenes as Gymnasium vector environments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils import env_checker
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import evastudio  # noqa: F401 - registers the scenes
from evastudio.errors import InvalidInputError
from evastudio.world.environment import SceneEnvironment
from evastudio.world.scene import Scene
from evastudio.world.vector_environment import SceneVectorEnvironment

SCENES = {
    "evastudio/Asteroids-v0": {"density": 10.0},
    "evastudio/Crowd-v0": {"people": 20, "length": 6},
}


@pytest.mark.parametrize("name", SCENES)
def test_single_ones_pass_gymnasiums_own_check(name: str) -> None:
    environment = gymnasium.make(name, **SCENES[name])
    env_checker.check_env(environment.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", SCENES)
def test_vector_ones_pass_gymnasiums_own_checks(name: str) -> None:
    """`check_env` takes single ones only: these are all its checks that a vector can be given."""
    environment: Any = gymnasium.make_vec(name, num_envs=5, **SCENES[name])
    assert type(environment.unwrapped) is SceneVectorEnvironment
    env_checker.check_reset_seed_determinism(environment)
    env_checker.check_reset_options(environment)
    env_checker.check_reset_return_type(environment)
    runs = []
    for _ in range(2):
        kept, _ = environment.reset(seed=3)
        before = kept.copy()
        environment.action_space.seed(3)
        runs.append([environment.step(environment.action_space.sample()) for _ in range(30)])
        assert np.array_equal(kept, before)
    for one, other in zip(*runs, strict=True):
        assert all(
            np.array_equal(ours, theirs) for ours, theirs in zip(one[:4], other[:4], strict=True)
        )
    env_checker.check_action_space(environment.single_action_space)
    env_checker.check_observation_space(environment.single_observation_space)


@pytest.mark.parametrize("name", SCENES)
def test_worlds_are_those_of_single_ones_and_follow_on_each_other(name: str) -> None:
    environment: Any = gymnasium.make_vec(name, num_envs=4, **SCENES[name])
    states, infos = environment.reset(seed=6)
    singles = [gymnasium.make(name, disable_env_checker=True, **SCENES[name]) for _ in range(4)]
    for single, seed, state in zip(singles, infos["seed"], states, strict=True):
        assert np.allclose(single.reset(seed=int(seed))[0], state, atol=1e-9)
    environment.action_space.seed(1)
    ends = 0
    for _ in range(2000):
        actions = environment.action_space.sample()
        states, rewards, terminated, truncated, infos = environment.step(actions)
        assert states in environment.observation_space
        assert not truncated.any()
        for row, single in enumerate(singles):
            state, reward, ended, _, info = single.step(actions[row])
            assert (reward, ended) == (pytest.approx(rewards[row], abs=1e-9), terminated[row])
            if ended:
                ends += 1
                assert np.allclose(infos["final_obs"][row], state, atol=1e-9)
                assert infos["final_info"]["outcome"][row] == info["outcome"]
                state, _ = single.reset(seed=int(infos["seed"][row]))
            assert np.allclose(state, states[row], atol=1e-9)
        if ends >= 5:
            break
    assert ends >= 5


def test_it_tells_what_gymnasiums_own_vector_of_singles_does(
    asteroids: Callable[..., Scene],
) -> None:
    """The same names, kinds and masks, step after step, as when single ones reset in one step."""
    scene = asteroids(density=10.0, half_width=30.0)
    ours = SceneVectorEnvironment(3, scene)
    theirs = SyncVectorEnv(
        [lambda: SceneEnvironment(scene)] * 3, autoreset_mode=AutoresetMode.SAME_STEP
    )
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    told = {False: set[str](), True: set[str]()}
    for environment in (ours, theirs):
        environment.reset(seed=2)
        seen = {False: set[str](), True: set[str]()}
        environment.action_space.seed(4)
        while not seen[True]:
            *_, terminated, _, infos = environment.step(environment.action_space.sample())
            seen[bool(terminated.any())] |= infos.keys()
            if terminated.any():
                for name in ("final_obs", "final_info"):
                    assert np.array_equal(infos[f"_{name}"], terminated)
                assert np.array_equal(infos["final_info"]["_outcome"], terminated)
        told = seen if environment is ours else told
    assert told[True] == seen[True]
    assert told[False] - {"seed", "_seed"} == seen[False]


def test_wrong_actions_and_no_worlds_are_refused(asteroids: Callable[..., Scene]) -> None:
    environment = SceneVectorEnvironment(2, asteroids())
    environment.reset(seed=1)
    with pytest.raises(InvalidInputError, match="NaN"):
        environment.step(np.full((2, 2), np.nan))
    with pytest.raises(InvalidInputError, match="expected"):
        environment.step(np.zeros((2, 3)))
    with pytest.raises(InvalidInputError, match="at least 1"):
        SceneVectorEnvironment(0, asteroids()).reset(seed=1)
