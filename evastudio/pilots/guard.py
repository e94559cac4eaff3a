"""A pilot under the scene's own guard: nobody is sent where there is no way."""

from __future__ import annotations

from collections.abc import Sequence

from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

GUARDED = "guarded:"
"""What the name of a pilot begins with that is to be guarded."""


class GuardedPilot(Pilot):
    """Acts as `pilot` does, but for those whose action would be in vain: `Scene.instead` is theirs.

    Every character is guarded, whoever guides it. What `pilot` remembers stays its own.
    """

    def __init__(self, pilot: Pilot) -> None:
        self.pilot = pilot
        self.name = GUARDED + pilot.name
        self.reactive = pilot.reactive

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return self.pilot.begin(scene, seeds)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        actions, memory = self.pilot.act(scene, snapshot, memory)
        return scene.instead(snapshot, actions), memory
