"""Straight flight: no action at all, the measure of how hard a world is."""

from __future__ import annotations

import numpy as np

from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


class StraightPilot(Pilot):
    """Gives the action nearest to zero, always."""

    name = "straight"
    reactive = True

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        shape = (snapshot.worlds, *scene.characters, scene.action.size)
        return scene.action.clip(np.zeros(shape)), memory
