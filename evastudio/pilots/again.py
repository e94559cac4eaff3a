"""Somebody who does again, step by step, what was once done."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


class AgainPilot(Pilot):
    """Does what was done at each step, whatever happens now, and rests when that is over."""

    name = "again"

    def __init__(self, actions: Array) -> None:
        """`actions` (steps, ..., action size), in the world's frame."""
        self._actions = actions

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return {"step": np.zeros(len(seeds), dtype=np.int64)}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        step = memory["step"]
        over = step >= len(self._actions)
        actions = self._actions[np.minimum(step, len(self._actions) - 1)].copy()
        actions[over] = scene.action.clip(np.zeros(scene.action.size))
        return actions, {"step": step + 1}
