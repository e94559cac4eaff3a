"""What a pilot costs: time to answer, to decide across a whole world, memory, file, search."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evastudio.evaluation.evaluate import MAX_STEPS
from evastudio.learning.policy import Policy
from evastudio.learning.policy_files import save_policy
from evastudio.pilots.astar import AStarPilot, Plan
from evastudio.world.rollout import Memory, Pilot, roll_out
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

CALLS = 500
"""Answers timed at once, so that the clock does not count."""


@dataclass(frozen=True)
class Costs:
    """Of one policy."""

    made_s: float
    """CPU seconds of fitting or searching."""
    answer_s: float
    """CPU seconds of one value of its function, for a state that is at hand."""
    memory_bytes: int
    """Of the arrays it decides by."""
    file_bytes: int


@dataclass(frozen=True)
class Crossing:
    """One world flown alone, with a clock at each decision."""

    decisions: int
    deciding_s: float
    """CPU seconds of all decisions, perception included."""
    good: bool
    """Whether it ended as the scene calls a success."""
    plans: tuple[tuple[int, int], ...] = ()
    """Of each search that a planner made: nodes expanded, and bytes held at its end."""


def costs(policy: Policy, states: Array, made_s: float, repeats: int) -> Costs:
    """Of `policy`, asked about `states` (rows, n) one by one."""
    decide = policy.learner.decide
    rows = [states[row : row + 1] for row in np.arange(CALLS) % len(states)]
    spent = []
    for _ in range(repeats + 1):
        start = time.process_time()
        for row in rows:
            decide(row)
        spent.append((time.process_time() - start) / CALLS)
    with tempfile.TemporaryDirectory() as folder:
        size = save_policy(policy, Path(folder) / "policy.safetensors").stat().st_size
    return Costs(made_s, statistics.median(spent[1:]), held_bytes(policy.learner), size)


def held_bytes(learner: Any) -> int:
    """Of all arrays that can be reached from `learner`, each counted once."""
    seen: dict[int, int] = {}
    left, known = [learner], set()
    while left:
        one = left.pop()
        if id(one) in known:
            continue
        known.add(id(one))
        if isinstance(one, np.ndarray):
            owner = one if one.base is None or not isinstance(one.base, np.ndarray) else one.base
            seen[id(owner)] = owner.nbytes
        elif isinstance(one, list | tuple):
            left.extend(one)
        elif isinstance(one, dict):
            left.extend(one.values())
        elif type(one).__module__.startswith("evastudio."):
            left.extend(getattr(one, "__dict__", {}).values())
    return sum(seen.values())


@dataclass(frozen=True)
class Clocked(Pilot):
    """`pilot`, with what its decisions cost noted in `spent`, CPU seconds."""

    pilot: Pilot
    spent: list[float]
    name: str = "clocked"

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return self.pilot.begin(scene, seeds)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        start = time.process_time()
        told = self.pilot.act(scene, snapshot, memory)
        self.spent.append(time.process_time() - start)
        return told


def cross(scene: Scene, pilot: Pilot, seed: int) -> Crossing:
    """`pilot` in the world of `seed`, alone; what is loaded at first use is not counted."""
    roll_out(scene, pilot, [seed], max_steps=3)
    plans: list[Plan] = []
    if isinstance(pilot, AStarPilot):
        pilot = replace(pilot, watch=plans.append)
    spent: list[float] = []
    flown = roll_out(scene, Clocked(pilot, spent), [seed], max_steps=MAX_STEPS)
    good = scene.outcomes[int(flown.outcomes[0])] in scene.successes
    searches = tuple((plan.expanded, plan.stored_bytes) for plan in plans)
    return Crossing(int(flown.steps[0]), sum(spent), good, searches)
