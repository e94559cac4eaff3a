"""A scene's Gymnasium environment as Stable-Baselines3 wants it, and practice in it.

Only `ppo.py` imports this: it needs `evastudio[rl]`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import stable_baselines3
import torch
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from evastudio.pilots.ppo import Weights
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import AnyArray
from evastudio.world.vector_environment import SceneVectorEnvironment

if TYPE_CHECKING:
    from evastudio.pilots.ppo import PPO

WIDE = 10.0
"""Actions are clipped by the world and not before, so that practice is as playing will be."""
UNBOUNDED = 1e9
"""Standardised states are not clipped, for the same reason."""


def lessons(settings: PPO, scene: Scene, view: Perception) -> Iterator[tuple[int, Weights]]:
    """Practise as `settings` say; after each lesson the decisions so far and the policy."""
    torch.set_num_threads(1)  # networks this small wait for each other otherwise
    environment = SceneVectorEnvironment(settings.worlds, scene, view)
    worlds = VecNormalize(
        Worlds(environment, seed=settings.seed, calm=settings.calm),
        norm_reward=False,
        clip_obs=UNBOUNDED,
        gamma=settings.discount,
    )
    learner = stable_baselines3.PPO(
        "MlpPolicy",
        worlds,
        n_steps=settings.between,
        batch_size=settings.batch,
        n_epochs=settings.epochs,
        learning_rate=settings.rate,
        gamma=settings.discount,
        policy_kwargs={"net_arch": {"pi": [settings.hidden], "vf": [64, 64]}},
        seed=settings.seed % 2**32,
        device="cpu",
    )
    lesson = settings.between * settings.worlds
    for number in range(-(-settings.decisions // lesson)):
        learner.learn(lesson, reset_num_timesteps=number == 0)
        yield int(learner.num_timesteps), _weights(learner, worlds)


def _weights(learner: Any, worlds: Any) -> Weights:
    policy, seen = learner.policy, worlds.obs_rms
    inner, outer = policy.mlp_extractor.policy_net[0], policy.action_net
    inner_weights, inner_bias, outer_weights, outer_bias = (
        part.detach().numpy().astype(np.float64)
        for part in (inner.weight, inner.bias, outer.weight, outer.bias)
    )
    return Weights(
        inner=inner_weights.T.copy(),
        inner_bias=inner_bias,
        outer=outer_weights.T.copy(),
        outer_bias=outer_bias,
        offset=np.array(seen.mean, dtype=np.float64),
        scale=np.sqrt(seen.var + worlds.epsilon),
    )


class Worlds(VecEnv):  # type: ignore[misc]
    """The worlds of an environment, with actions in shares of half their range.

    Each action costs `calm` times its square. Stable-Baselines3 wants a new world in the step in
    which one ends, and the last state of the old one in the infos, as the environment has it.
    """

    def __init__(self, environment: SceneVectorEnvironment, *, seed: int, calm: float) -> None:
        self.environment = environment
        self.begins_with = seed
        self.calm = calm
        state, action = environment.perception.state, environment.chosen
        self.half = (action.high - action.low) / 2
        self.middle = (action.high + action.low) / 2
        super().__init__(
            environment.num_envs,
            spaces.Box(state.low.astype(np.float32), state.high.astype(np.float32)),
            spaces.Box(-WIDE, WIDE, (action.size,)),
        )

    def reset(self) -> AnyArray:
        states, _ = self.environment.reset(seed=self.begins_with)
        return states.astype(np.float32)

    def step_async(self, actions: AnyArray) -> None:
        self.actions = actions.astype(np.float64)

    def step_wait(self) -> tuple[AnyArray, AnyArray, AnyArray, list[dict[str, Any]]]:
        turned = self.actions * self.half + self.middle
        states, rewards, terminated, truncated, told = self.environment.step(turned)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in ended]
        for world in np.flatnonzero(ended):
            infos[world] = {
                "terminal_observation": told["final_obs"][world].astype(np.float32),
                "TimeLimit.truncated": bool(truncated[world] and not terminated[world]),
            }
        effort = (np.clip(self.actions, -1.0, 1.0) ** 2).sum(axis=1)
        rewards = rewards - self.calm * effort
        return states.astype(np.float32), rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        self.environment.close()

    # -- what Stable-Baselines3 asks beside; these worlds have nothing of the kind -------------

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        pass

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        return [None] * self.num_envs

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> Sequence[bool]:
        return [False] * self.num_envs
