"""Conditions watched over time, world by world and character by character."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.world.conditions import Condition, read
from evastudio.world.rollout import Memory
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot

STEPS, HELD = "steps", "held"


@dataclass(frozen=True)
class Watch:
    """What a pilot that looks at `conditions` at every decision needs to remember."""

    conditions: tuple[Condition, ...]

    def begin(self, scene: Scene, worlds: int) -> Memory:
        """Nothing has held in new worlds."""
        held = np.zeros((worlds, *scene.characters, len(self.conditions)), dtype=np.bool_)
        return {STEPS: np.zeros(worlds, dtype=np.int64), HELD: held}

    def look(
        self, scene: Scene, snapshot: Snapshot, memory: Memory
    ) -> tuple[NDArray[np.bool_], Memory]:
        """Which conditions hold now, (worlds, conditions), with an axis for characters between
        where there are many; and the memory for the next decision."""
        names = dict.fromkeys(name for one in self.conditions for name in one.readings)
        told = read(scene, snapshot, memory[STEPS] * scene.dt_s, names)
        held = memory[HELD].copy()
        for number, condition in enumerate(self.conditions):
            now = condition.holds(told)
            held[..., number] = now | held[..., number] if condition.once else now
        return held, {STEPS: memory[STEPS] + 1, HELD: held}
