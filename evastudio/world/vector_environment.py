"""Scenes as Gymnasium vector environments: `gymnasium.make_vec("evastudio/Crowd-v0", 64)`."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from evastudio.world.environment import in_gymnasium, made
from evastudio.world.practice import Practice
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array

Infos = dict[str, Any]


class SceneVectorEnvironment(VectorEnv):
    """`num_envs` worlds of a scene, all stepped in one call; each is a `SceneEnvironment`.

    A world that ends is followed by another in the same step: the observation is of the new one,
    and `final_obs` and `final_info` of the infos hold the last of the old. `seed` of the infos
    says by which seed `SceneEnvironment.reset` gives the same world.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - gymnasium's convention
        "render_modes": [],
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self,
        num_envs: int,
        scene: str | Scene,
        perception: str | Perception | None = None,
        **options: float,
    ) -> None:
        self.num_envs = num_envs
        self.scene = made(scene, options)
        self.perception = self.scene.perception(perception)
        self.chosen = self.scene.chosen(self.perception)
        self.single_observation_space = in_gymnasium(self.perception.state)
        self.single_action_space = in_gymnasium(self.chosen)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, Infos]:
        """New worlds, those of `Practice` by `seed`, or by one that follows from the last."""
        super().reset(seed=seed)
        chosen = int(self.np_random.integers(2**53)) if seed is None else seed
        self._practice = Practice(self.scene, self.perception, worlds=self.num_envs, seed=chosen)
        return self._practice.states, {"seed": self._practice.seeds, "_seed": self._all()}

    def step(
        self, actions: Any
    ) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_], Infos]:
        """One decision step with `actions` (num_envs, m), or codes (num_envs,) of symbols."""
        given = np.asarray(actions, dtype=np.float64).reshape(self.num_envs, -1)
        told = self._practice.step(self.chosen.check(given, "actions"))
        ended = told.outcomes != 0
        outcomes = np.array(self.scene.outcomes, dtype=object)[told.outcomes]
        infos: Infos = {
            "outcome": _only(outcomes, ~ended),
            "_outcome": ~ended,
            "seed": self._practice.seeds,
            "_seed": ended,
        }
        if ended.any():
            last = np.full(self.num_envs, None, dtype=object)
            for world, state in zip(np.flatnonzero(ended), told.last, strict=True):
                last[world] = state
            final = {"outcome": _only(outcomes, ended), "_outcome": ended}
            infos |= {"final_obs": last, "_final_obs": ended}
            infos |= {"final_info": final, "_final_info": ended}
        return told.states, told.rewards, ended, np.zeros(self.num_envs, dtype=np.bool_), infos

    def _all(self) -> NDArray[np.bool_]:
        return np.ones(self.num_envs, dtype=np.bool_)


def _only(values: AnyArray, chosen: NDArray[np.bool_]) -> AnyArray:
    """`values` where `chosen`, None elsewhere, as Gymnasium's infos have it."""
    kept = np.full(len(values), None, dtype=object)
    kept[chosen] = values[chosen]
    return kept
