"""Worlds to practise in: a batch where a new world begins wherever one has ended."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.cast import for_all, of_lead
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


def rewarded(scene: Scene, before: Snapshot, after: Snapshot) -> tuple[Array, NDArray[np.int64]]:
    """What a step from `before` to `after` earned in each world, and its outcome; (worlds,) each.

    The gain in progress, plus 1 for an end that is a success and minus 1 for any other end.
    """
    outcomes = scene.outcome(after)
    good = np.isin(outcomes, [scene.outcomes.index(name) for name in scene.successes])
    end = np.where(outcomes == 0, 0.0, np.where(good, 1.0, -1.0))
    return scene.progress(after) - scene.progress(before) + end, outcomes


@dataclass(frozen=True)
class Practised:
    """What one step of all worlds gave."""

    states: Array
    """Perceived now, (worlds, n); where a world ended, of the one that has begun in its place."""
    rewards: Array
    """(worlds,)"""
    outcomes: NDArray[np.int64]
    """(worlds,), 0 where a world goes on."""
    last: Array
    """The last states of those that ended, in their order, (ended, n)."""


class Practice:
    """`worlds` worlds of `scene` that follow from `seed`, each followed by another when it ends.

    States are those of `perception`, actions are in its frame; of many characters the lead acts
    and the others rest. `seeds` (worlds,) are those of the worlds there are now. Raises
    InvalidInputError for fewer than one world.
    """

    def __init__(
        self, scene: Scene, perception: str | Perception | None = None, *, worlds: int, seed: int
    ) -> None:
        if worlds < 1:
            raise InvalidInputError(f"{worlds} worlds were asked for; practise in at least 1.")
        self.scene = scene
        self.perception = scene.perception(perception)
        self.worlds = worlds
        self._rng = np.random.default_rng(seed)
        self.seeds, begun = self._begun(worlds)
        # What is fixed is large, and changes a few worlds at a time: it is kept in one place.
        self._fixed = {name: np.array(array) for name, array in begun.fixed.items()}
        self._snapshot = Snapshot(self._fixed, begun.moving)
        self.states = self._perceived()

    def step(self, actions: Array) -> Practised:
        """One decision step of all with `actions` (worlds, m), or the nearest that there are."""
        before = self._snapshot
        turned = self.scene.action.clip(self.perception.to_world(self._frame, actions))
        after = self.scene.step(before, for_all(self.scene, before, turned))
        rewards, outcomes = rewarded(self.scene, before, after)
        ended = np.flatnonzero(outcomes)
        last = self.states[:0]
        if len(ended):
            over = after.take(ended)
            last = of_lead(over, self.perception.perceive(over).states)
            seeds, begun = self._begun(len(ended))
            self.seeds = self.seeds.copy()
            self.seeds[ended] = seeds
            for name, array in begun.fixed.items():
                self._fixed[name][ended] = array
            moving = {name: array.copy() for name, array in after.moving.items()}
            for name, array in begun.moving.items():
                moving[name][ended] = array
            after = Snapshot(self._fixed, moving)
        self._snapshot = after
        self.states = self._perceived()
        return Practised(self.states, rewards, outcomes, last)

    def _begun(self, count: int) -> tuple[NDArray[np.int64], Snapshot]:
        """The seeds of `count` new worlds, and the worlds."""
        seeds = self._rng.integers(2**53, size=count)
        return seeds, self.scene.worlds([int(seed) for seed in seeds])

    def _perceived(self) -> Array:
        percept = self.perception.perceive(self._snapshot)
        self._frame = of_lead(self._snapshot, percept.frame)
        return of_lead(self._snapshot, percept.states)
