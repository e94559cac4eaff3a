"""Worlds on their way: those that go on are stepped, those that have ended stay as they ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.world.scene import Percept, Perception, Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Seen:
    """What a program sees of all worlds of a batch. Those that have ended stay as they ended."""

    states: Array
    """Perceived now, (worlds, n), or of everybody where many act, (worlds, characters, n)."""
    outcomes: NDArray[np.int64]
    """Index into the scene's `outcomes`, 0 while a world runs; (worlds,)."""
    progress: Array
    """How far each has come, 0 to 1; (worlds,)."""
    steps: NDArray[np.int64]
    """Decisions taken in each, (worlds,)."""

    def arrays(self) -> dict[str, AnyArray]:
        """By name."""
        return dict(vars(self))


class Stepping:
    """Worlds of `scene` from the moment `snapshot` on, stepped exactly as `roll_out` steps them.

    `steps` (worlds,) is how many decisions came before. A step takes those that go on out of the
    batch and writes them back where they are looked at, so that it copies nothing.
    """

    def __init__(
        self,
        scene: Scene,
        view: Perception,
        seeds: Sequence[int],
        snapshot: Snapshot,
        steps: NDArray[np.int64],
    ) -> None:
        self.scene = scene
        self.view = view
        self.seeds = tuple(seeds)
        self.alive: NDArray[np.int64] = np.arange(snapshot.worlds)
        """Which worlds go on."""
        self.going = snapshot
        """Those, in that order."""
        self._percept: Percept | None = None
        self._fixed = snapshot.fixed
        self._moving = {name: np.array(array) for name, array in snapshot.moving.items()}
        self._states = np.array(self.percept.states)
        self._outcomes = np.array(scene.outcome(snapshot))
        self._progress = np.array(scene.progress(snapshot))
        self._steps = np.array(steps)
        self._noted = True
        self._leave(self._outcomes == 0)

    @property
    def percept(self) -> Percept:
        """What is perceived now in the worlds that go on."""
        if self._percept is None:
            self._percept = self.view.perceive(self.going)
        return self._percept

    def advance(self, actions: Array) -> NDArray[np.bool_]:
        """One decision step of the worlds that go on; which of them still do, in their order."""
        after = self.scene.step(self.going, actions)
        outcomes = self.scene.outcome(after)
        self.going, self._percept, self._noted = after, None, False
        self._steps[self.alive] += 1
        self._outcomes[self.alive] = outcomes
        on: NDArray[np.bool_] = outcomes == 0
        if not on.all():
            self._note()
            self._leave(on)
        return on

    def see(self) -> Seen:
        """All worlds as they are now."""
        self._note()
        return Seen(
            self._states.copy(), self._outcomes.copy(), self._progress.copy(), self._steps.copy()
        )

    def snapshot(self) -> Snapshot:
        """The moment of all worlds."""
        self._note()
        return Snapshot(self._fixed, {name: array.copy() for name, array in self._moving.items()})

    def _note(self) -> None:
        """Write those that go on back among all."""
        if self._noted:
            return
        self._states[self.alive] = self.percept.states
        self._progress[self.alive] = self.scene.progress(self.going)
        for name, array in self._moving.items():
            array[self.alive] = self.going.moving[name]
        self._noted = True

    def _leave(self, on: NDArray[np.bool_]) -> None:
        """Go on with those alone; the others are noted."""
        if not on.all():
            self.alive, self.going, self._percept = self.alive[on], self.going.take(on), None
