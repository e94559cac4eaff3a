"""Reinforcement learning by networks: what of it needs no extra."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.policy_files import load_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.ppo import PPO, Weights, as_network
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.spaces import Box, Field

TRAINED = sorted((shipped() / "benchmarks" / "trained").glob("asteroids-ppo-canonical*"))


def test_without_the_extra_it_says_what_to_install(
    asteroids: Callable[..., Scene], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.delitem(sys.modules, "evastudio.pilots.stable_baselines", raising=False)
    with pytest.raises(ConflictError, match=r"'stable_baselines3'.*evastudio\[rl\]"):
        PPO(decisions=1).learn(asteroids())


def test_symbols_and_settings_without_a_meaning_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="symbols"):
        PPO().learn(load_scene_file(shipped() / "scenes" / "crowd.py")())
    with pytest.raises(InvalidInputError, match="worlds is 0"):
        PPO(worlds=0)
    with pytest.raises(InvalidInputError, match=r"discount is 1\.5"):
        PPO(discount=1.5)


def test_what_was_practised_is_what_the_policy_decides() -> None:
    rng = np.random.default_rng(0)
    weights = Weights(*(rng.normal(size=shape) for shape in ((3, 4), 4, (4, 2), 2, 3)), np.ones(3))
    action = Box((Field("a", "1", -2.0, 2.0), Field("b", "1", 0.0, 1.0)))
    states = rng.normal(size=(5, 3))
    units = np.tanh((states - weights.offset) @ weights.inner + weights.inner_bias)
    share = units @ weights.outer + weights.outer_bias
    given = as_network(PPO(hidden=4), weights, action).decide(states)
    assert given == pytest.approx(share * (2.0, 0.5) + (0.0, 0.5))


@pytest.mark.parametrize("path", TRAINED, ids=lambda path: path.stem)
def test_what_it_learned_crosses_unseen_fields(path: Path, asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=4.0, half_width=100.0)
    flown = roll_out(scene, PolicyPilot(load_policy(path)), world_seeds(31, 20))
    assert (flown.outcomes == scene.outcomes.index("crossed")).mean() >= 0.9
