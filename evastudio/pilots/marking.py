"""A demonstrator who marks moments by a written rule, as an animator does with a key."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evastudio.errors import ConflictError
from evastudio.pilots.memories import named, within
from evastudio.pilots.watching import HELD, Watch
from evastudio.world.cast import for_all, of_lead
from evastudio.world.conditions import Condition
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import MARK, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

_PILOT, _RULE = "pilot.", "rule."


class MarkingPilot(Pilot):
    """Acts as `pilot`, and marks every moment when `rule` begins or ceases to hold of the lead."""

    def __init__(self, pilot: Pilot, rule: Condition) -> None:
        self.pilot = pilot
        self.name = pilot.name
        self._watch = Watch((rule,))

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        mark_field(scene)
        watched = self._watch.begin(scene, len(seeds))
        return {**named(_PILOT, self.pilot.begin(scene, seeds)), **named(_RULE, watched)}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        watched = within(_RULE, memory)
        actions, own = self.pilot.act(scene, snapshot, within(_PILOT, memory))
        holds, after = self._watch.look(scene, snapshot, watched)
        lead = of_lead(snapshot, actions).copy()
        changes = of_lead(snapshot, holds ^ watched[HELD])[..., 0]
        lead[:, mark_field(scene)] = np.where(changes, 1.0, 0.0)
        remembered = {**named(_PILOT, own), **named(_RULE, after)}
        return for_all(scene, snapshot, lead, actions), remembered


def mark_field(scene: Scene) -> int:
    """The component of `scene`'s action that marks a moment. Raises ConflictError without one."""
    field = next((signal.field for signal in scene.signals if signal.name == MARK), None)
    if field is None:
        raise ConflictError(
            f"Scene {scene.name!r} has no signal {MARK!r}, so no moment can be marked in it. "
            "Write the condition of the switch instead."
        )
    return scene.action.names.index(field)
