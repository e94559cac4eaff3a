"""Worlds that begin anew where they end, for learning by reward."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.world.environment import SceneEnvironment
from evastudio.world.practice import Practice
from evastudio.world.scene import Scene


def test_a_batch_gives_what_environments_give_one_by_one(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=10.0)
    practice = Practice(scene, worlds=6, seed=3)
    seeds = np.random.default_rng(3).integers(2**53, size=200)
    environments = [SceneEnvironment(scene) for _ in range(6)]
    for row, environment in enumerate(environments):
        environment.reset(seed=int(seeds[row]))
    begun, rng = 6, np.random.default_rng(4)
    while begun < 12:
        actions = scene.action.at(rng.random((6, 2)))
        told = practice.step(actions)
        last = []
        for row, environment in enumerate(environments):
            state, reward, ended, _, info = environment.step(actions[row])
            assert reward == pytest.approx(told.rewards[row], abs=1e-12)
            assert info["outcome"] == scene.outcomes[told.outcomes[row]]
            if ended:
                last.append(state)
                state, _ = environment.reset(seed=int(seeds[begun]))
                begun += 1
            assert np.allclose(state, told.states[row], atol=1e-9)
        assert np.allclose(told.last, np.reshape(last, (-1, 6)), atol=1e-9)


def test_the_same_seed_practises_the_same(asteroids: Callable[..., Scene]) -> None:
    first, second = (Practice(asteroids(), "paper", worlds=3, seed=8) for _ in range(2))
    for _ in range(5):
        assert np.array_equal(first.step(np.zeros((3, 2))).states, first.states)
        second.step(np.zeros((3, 2)))
    assert np.array_equal(first.states, second.states)


def test_no_world_to_practise_in_is_refused(asteroids: Callable[..., Scene]) -> None:
    with pytest.raises(InvalidInputError, match="at least 1"):
        Practice(asteroids(), worlds=0, seed=1)
