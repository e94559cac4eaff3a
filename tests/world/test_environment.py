"""Scenes as Gymnasium environments."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.world.environment import SceneEnvironment
from evastudio.world.scene import Scene


def test_an_episode_is_the_same_world_as_anywhere_else(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=0.5)
    environment = SceneEnvironment(scene)
    state, _ = environment.reset(seed=42)
    snapshot = scene.worlds([42])
    assert np.array_equal(state, scene.perception().perceive(snapshot).states[0])
    total, ended, steps = 0.0, False, 0
    while not ended:
        state, reward, ended, _, info = environment.step(np.zeros(2))
        total += reward
        steps += 1
    assert info["outcome"] in scene.outcomes[1:]
    good = info["outcome"] in scene.successes
    assert total == pytest.approx(2.0 if good else steps * 10 / 15 / 360 - 1.0, abs=0.01)


def test_a_wrong_action_is_refused(asteroids: Callable[..., Scene]) -> None:
    environment = SceneEnvironment(asteroids())
    environment.reset(seed=1)
    with pytest.raises(InvalidInputError, match="NaN"):
        environment.step(np.array([np.nan, 0.0]))
    with pytest.raises(InvalidInputError, match="expected"):
        environment.step(np.zeros(3))
