"""A switchboard: several policies for one character, and which of them acts when.

Each character decides for itself, so that in a crowd some may flee while others walk on. What a
policy chooses, symbols or numbers, its perception has turned into the scene's action by then, so
that both kinds can take turns (paper, section 4.2: a grid before the impact, free running after).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import ConflictError
from evastudio.learning.switch import Switch
from evastudio.pilots.memories import named, within
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.watching import Watch
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

_WATCH = "watch."


class Switchboard(Pilot):
    """Of `pilots`, one for each entry of `switch`, the first whose condition holds acts."""

    def __init__(self, switch: Switch, pilots: Sequence[Pilot], name: str = "switch") -> None:
        self.switch = switch
        self.pilots = tuple(pilots)
        self.name = name
        self._watch = Watch(tuple(one.when for one in switch.entries if one.when is not None))

    def check(self, scene: Scene) -> None:
        """Raise ConflictError where the switch or a policy of it was not made for `scene`."""
        made_for = (self.switch.scene["name"], self.switch.scene["version"])
        if made_for != (scene.name, scene.version):
            raise ConflictError(
                f"The switch was made for scene {made_for[0]!r} version {made_for[1]}, and this is "
                f"scene {scene.name!r} version {scene.version}. Make one for this scene."
            )
        for condition in self._watch.conditions:
            condition.check(scene)
        for pilot in self.pilots:
            if isinstance(pilot, PolicyPilot):
                pilot.check(scene)

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        memory = dict(named(_WATCH, self._watch.begin(scene, len(seeds))))
        for number, pilot in enumerate(self.pilots):
            memory |= named(f"{number}.", pilot.begin(scene, seeds))
        return memory

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        """A policy that only reacts is asked in those worlds alone where it acts for somebody."""
        acting, watched = self.acting(scene, snapshot, memory)
        after = {**memory, **watched}
        actions = np.zeros((snapshot.worlds, *scene.characters, scene.action.size))
        for number, pilot in enumerate(self.pilots):
            asked = acting == number
            worlds = asked.reshape(snapshot.worlds, -1).any(axis=1)
            if not pilot.reactive:
                worlds[:] = True
            if not worlds.any():
                continue
            own = within(f"{number}.", memory)
            if worlds.all():
                given, own = pilot.act(scene, snapshot, own)
            else:
                theirs = {name: array[worlds] for name, array in own.items()}
                given, changed = pilot.act(scene, snapshot.take(worlds), theirs)
                own = {name: _put(array, worlds, changed[name]) for name, array in own.items()}
            actions[asked] = given[asked[worlds]]
            after |= named(f"{number}.", own)
        return actions, after

    def acting(
        self, scene: Scene, snapshot: Snapshot, memory: Memory
    ) -> tuple[NDArray[np.int64], Memory]:
        """Which entry acts now, (worlds,), or (worlds, characters); and the watch's memory."""
        holds, watched = self._watch.look(scene, snapshot, within(_WATCH, memory))
        last = np.ones((*holds.shape[:-1], 1), dtype=np.bool_)
        chosen = np.concatenate([holds, last], axis=-1).argmax(axis=-1)
        return np.asarray(chosen), named(_WATCH, watched)


def _put(array: AnyArray, worlds: NDArray[np.bool_], values: AnyArray) -> AnyArray:
    """A copy of `array` with `values` for some of its worlds."""
    changed = array.copy()
    changed[worlds] = values
    return changed
