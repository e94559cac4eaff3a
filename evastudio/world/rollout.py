"""Rollouts: a pilot flies a batch of worlds to their ends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

Memory = Mapping[str, AnyArray]
"""What a pilot remembers of each world: arrays with `worlds` as their leading axis."""


class Pilot(ABC):
    """Anything that chooses actions. What it remembers is an argument, so it can be shared."""

    name: str
    reactive: bool = False
    """Whether it may be left unasked for some decisions: it remembers nothing of what it saw."""

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        """The memory for new worlds with these seeds; what is random follows from them alone."""
        return {}

    @abstractmethod
    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        """Actions (worlds, action size) in the world's frame, and the memory for the next step.

        In a scene of many characters the actions of all, (worlds, characters, action size).
        """


@dataclass(frozen=True)
class Rollout:
    """What became of a batch of worlds."""

    seeds: tuple[int, ...]
    outcomes: NDArray[np.int64]
    """Index into the scene's `outcomes`, shape (worlds,); 0 where `max_steps` ran out first."""
    steps: NDArray[np.int64]
    """Decisions taken, shape (worlds,)."""
    turn: Array
    """Mean change of action a step: |change| per component as a share of the range, or for symbols
    the share of steps that chose another; (worlds,)."""


Watcher = Callable[[NDArray[np.int64], Snapshot, Array], None]
"""Called each step with the worlds still running, their snapshot and the actions chosen."""


def roll_out(
    scene: Scene,
    pilot: Pilot,
    seeds: Sequence[int],
    *,
    start: Snapshot | None = None,
    max_steps: int = 100_000,
    watcher: Watcher | None = None,
) -> Rollout:
    """Run `pilot` in one world for each seed until all have ended or `max_steps` have passed.

    `start` are these very worlds where they are at hand; they need not be at their beginning.
    Ended worlds leave the batch. The result for a world depends on its own seed alone.
    """
    snapshot = scene.worlds(seeds) if start is None else start
    memory = pilot.begin(scene, seeds)
    alive = np.arange(len(seeds))
    outcomes = np.zeros(len(seeds), dtype=np.int64)
    steps = np.zeros(len(seeds), dtype=np.int64)
    change = np.zeros(len(seeds))
    last: Array | None = None
    for _ in range(max_steps):
        actions, memory = pilot.act(scene, snapshot, memory)
        actions = scene.action.clip(actions)
        if watcher is not None:
            watcher(alive, snapshot, actions)
        snapshot = scene.step(snapshot, actions)
        steps[alive] += 1
        if last is not None:
            size = scene.action.size
            changes = scene.action.change(last.reshape(-1, size), actions.reshape(-1, size))
            change[alive] += changes.reshape(len(alive), -1).mean(axis=1)
        now = scene.outcome(snapshot)
        outcomes[alive] = now
        going = now == 0
        if not going.all():
            alive, actions = alive[going], actions[going]
            if len(alive) == 0:
                break
            snapshot = snapshot.take(going)
            memory = {name: array[going] for name, array in memory.items()}
        last = actions
    return Rollout(tuple(seeds), outcomes, steps, change / np.maximum(steps - 1, 1))
