"""Scenes as Gymnasium environments: `gymnasium.make("evastudio/Asteroids-v0")`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from evastudio.errors import InvalidInputError
from evastudio.workspace import shipped
from evastudio.world.cast import for_all, of_lead
from evastudio.world.loading import find_scene
from evastudio.world.practice import rewarded
from evastudio.world.scene import Scene
from evastudio.world.spaces import Array, Space, Symbols


def made(scene: str | Scene, options: Mapping[str, float]) -> Scene:
    """The shipped scene of that name with `options`, or the one given.

    Raises NotFoundError for an unknown name, InvalidInputError for options beside a scene.
    """
    if isinstance(scene, str):
        return find_scene(scene, (shipped() / "scenes",))(**options)
    if options:
        raise InvalidInputError(
            f"Options {sorted(options)} were given beside a scene that is made already; give "
            "its name, or make it with them."
        )
    return scene


def in_gymnasium(space: Space) -> spaces.Space[Any]:
    """`space` as Gymnasium knows it; symbols are their codes."""
    if isinstance(space, Symbols):
        return spaces.Discrete(len(space.names))
    return spaces.Box(space.low, space.high, dtype=np.float64)


class SceneEnvironment(gymnasium.Env):
    """One world of a scene. Observations are states of a perception, actions are in its frame.

    Actions that are symbols are given as their codes. Of many characters the lead acts, and the
    others rest. The reward is that of `rewarded`.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - gymnasium's convention

    def __init__(self, scene: str | Scene, perception: str | None = None, **options: float) -> None:
        self.scene = made(scene, options)
        self.perception = self.scene.perception(perception)
        self.chosen = self.scene.chosen(self.perception)
        self.observation_space = in_gymnasium(self.perception.state)
        self.action_space = in_gymnasium(self.chosen)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """A new world. The same seed gives the same world as anywhere else in the studio."""
        super().reset(seed=seed)
        chosen = int(self.np_random.integers(2**53)) if seed is None else seed
        self._snapshot = self.scene.worlds([chosen])
        return self._observe(), {"seed": chosen}

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        actions = np.asarray(action, dtype=np.float64).reshape(1, -1)
        actions = self.chosen.check(actions, "actions")
        before = self._snapshot
        turned = self.perception.to_world(self._frame, actions)
        self._snapshot = self.scene.step(before, for_all(self.scene, before, turned))
        rewards, outcomes = rewarded(self.scene, before, self._snapshot)
        ended = bool(outcomes[0] != 0)
        told = {"outcome": self.scene.outcomes[int(outcomes[0])]}
        return self._observe(), float(rewards[0]), ended, False, told

    def _observe(self) -> Array:
        percept = self.perception.perceive(self._snapshot)
        self._frame = of_lead(self._snapshot, percept.frame)
        state: Array = of_lead(self._snapshot, percept.states)[0]
        return state
