"""How a crowd walks under a pilot: how often people are blocked, get stuck, and where they go.

What `crowd.py` measures; nothing here is run by itself.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import ROOT
from evastudio.demonstrations.pairs import Pairs, join_pairs, perceive_take
from evastudio.evaluation.flight import Logbook
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.guard import GuardedPilot
from evastudio.pilots.lead import LeadPilot
from evastudio.scenery.grid import clearances, eighths, wrapped
from evastudio.scenery.mingling import cells_a_minute, longest_still_s, longest_stuck_s
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import Memory, Pilot, roll_out
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

CROWD: Any = load_scene_file(ROOT / "scenes" / "crowd.py")
SCENE: Any = sys.modules[CROWD.__module__]
A_MINUTE = 120
"""Decisions."""

Codes = NDArray[np.int64]


@dataclass(frozen=True)
class Walked:
    """How a crowd fared in one world, means over people and time but for what says longest."""

    blocked: float
    """Times a minute that somebody walked into no free cell."""
    helped: float
    """Times a minute that the guard chose instead."""
    stuck_s: float
    """Longest time from wanting to walk on, and not getting to, until leaving the cell."""
    still_s: float
    """Longest time in one cell, not counting decisions to stand."""
    cells: float
    """Different cells that somebody stands in within a minute."""
    standing: float
    """Share of the decisions that are to stand."""
    turning: float
    """Share of the decisions that are to turn."""
    room: float
    """Free cells ahead of those who walk on, of at most 5."""


class Wishing(Pilot):
    """Does as `pilot`, and keeps what it wanted for a look from outside."""

    def __init__(self, pilot: Pilot) -> None:
        self.pilot, self.name = pilot, pilot.name
        self.wished = np.zeros(0)

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return self.pilot.begin(scene, seeds)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        self.wished, memory = self.pilot.act(scene, snapshot, memory)
        return self.wished, memory


def walk(
    pilot: Pilot, people: int, side: int, minutes: float, seeds: Sequence[int], guard: bool
) -> list[Walked]:
    """`pilot` walks everybody in the worlds of `seeds`; one result for each."""
    scene = CROWD(people=people, side=side, length=3600.0)
    bare = Wishing(pilot)
    cells: list[Codes] = []
    wishes: list[Codes] = []
    given: list[Codes] = []
    rooms: list[Array] = []
    blocked = [np.zeros(0)]

    def watch(_: NDArray[np.int64], snapshot: Snapshot, actions: Array) -> None:
        here = SCENE.cells_of(snapshot)
        facing = eighths(snapshot["heading"])
        cells.append(wrapped(here, side) @ (1, side))
        wishes.append(SCENE.symbols(bare.wished))
        given.append(SCENE.symbols(actions))
        rooms.append(clearances(here, facing, side, (0,))[:, :, 0])
        blocked[0] = snapshot["blocked"]

    steps = round(minutes * A_MINUTE) + 1
    chosen = GuardedPilot(bare) if guard else bare
    roll_out(scene, chosen, seeds, max_steps=steps, watcher=watch)
    where = np.array(cells)
    wished, done, room = (np.array(kept[:-1]) for kept in (wishes, given, rooms))
    stuck_s = longest_stuck_s(where, wished == SCENE.WALK, scene.dt_s)
    still_s = longest_still_s(where, wished == SCENE.STAND, scene.dt_s)
    visited = cells_a_minute(where[:-1], scene.dt_s)
    turning = (done == SCENE.LEFT) | (done == SCENE.RIGHT)
    return [
        Walked(
            blocked=float(blocked[0][world].mean()) / minutes,
            helped=float((wished != done)[:, world].sum()) / people / minutes,
            stuck_s=float(stuck_s[world].max()),
            still_s=float(still_s[world].max()),
            cells=float(visited[world].mean()),
            standing=float((done == SCENE.STAND)[:, world].mean()),
            turning=float(turning[:, world].mean()),
            room=float(room[:, world].mean(where=(done == SCENE.WALK)[:, world])),
        )
        for world in range(len(seeds))
    ]


class Quantised(Pilot):
    """A real-valued `learner` of turn and walk whose answers are moved to the nearest symbol."""

    def __init__(self, learner: KNNPolicy | SVRPolicy, perception: str) -> None:
        self.learner, self.perception, self.name = learner, perception, "quantised"

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        states = scene.perceptions[self.perception].perceive(snapshot).states
        moves = self.learner.decide(states.reshape(-1, states.shape[-1]))
        apart = ((moves[:, None] - SCENE.MOVES) ** 2).sum(axis=2)
        actions = np.zeros((*states.shape[:-1], scene.action.size))
        actions[..., :2] = SCENE.MOVES[apart.argmin(axis=1)].reshape(*states.shape[:-1], 2)
        return actions, memory


class Redrawing(Pilot):
    """A drawing `pilot` whose lot is drawn again for those it would send where there is no way."""

    TIMES = 4

    def __init__(self, pilot: Pilot) -> None:
        self.pilot, self.name = pilot, pilot.name

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        return self.pilot.begin(scene, seeds)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        actions, after = self.pilot.act(scene, snapshot, memory)
        for again in range(self.TIMES):
            vain = (scene.instead(snapshot, actions) != actions).any(axis=2)
            if not vain.any():
                break
            other = {**memory, "seed": memory["seed"] + np.uint64(again + 1)}
            redrawn, _ = self.pilot.act(scene, snapshot, other)
            actions = np.where(vain[..., None], redrawn, actions)
        return actions, after


def demonstrated(pilot: Pilot, seed: int, minutes: float, still: bool) -> dict[str, Pairs]:
    """The pairs of the lead under each perception of the square, as a session has them.

    Among people who are `still`, as in the studio, or who all walk as the lead does.
    """
    scene = CROWD(length=60.0)
    pairs: dict[str, list[Pairs]] = {}
    for take in range(round(minutes)):
        log = Logbook(scene)
        lead = LeadPilot(pilot, None if still else pilot)
        roll_out(scene, lead, [seed * 1000 + take], watcher=log)
        (flight,) = log.flights()
        for name in ("paper", "own", "ahead", "paths"):
            view = scene.perceptions[name]
            found = perceive_take(view, flight.moments, flight.actions, take)
            pairs.setdefault(name, []).append(found)
    return {name: join_pairs(parts) for name, parts in pairs.items()}
