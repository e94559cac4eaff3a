"""A*: looks for the quickest way through the world as it is, a few decisions at a time.

Hart, Nilsson, Raphael, "A formal basis for the heuristic determination of minimum cost paths",
1968; the paper compares with it in section 4.1 and table 2. It learns nothing, is shown nothing
and perceives nothing: it searches the true world, which `Scene.course` tells it, and therefore
flies only where a scene has one.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.course import Course
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

SLICE = 100
"""Nodes expanded between two looks at the clock, where there is a limit of time."""


@dataclass(frozen=True)
class Plan:
    """What one search gave."""

    actions: Array
    """To take one after the other, shape (decisions, 2); none where every way is blocked."""
    cost_s: float
    """How long they take, seconds."""
    finished: bool
    """Whether the goal was reached; else they lead as far ahead as was found."""
    expanded: int
    """Nodes whose successors were made."""
    stored_bytes: int
    """Memory of the open and the closed list at the end, when they are largest."""


@dataclass(frozen=True)
class AStarPilot(Pilot):
    """Plans over motion primitives, flies the first `every` decisions, and plans again.

    A primitive turns by the same action for `hold` decisions. A node costs the time flown to it,
    and no way is quicker than straight ahead to the far plane: that is the heuristic, admissible
    and consistent. The search ends at the plane, or `sight_m` ahead of the start where that is
    nearer. Where the limit comes first, the plan is the way to the node farthest ahead: the
    search can be stopped at any time. With `merge_m` above zero, ways that come to the same place
    are merged, which makes the search smaller and the way at most a little longer than the best
    of these primitives; at zero it is the best of them.
    """

    name: str = "astar"
    levels: tuple[float, ...] = (-1.0, 0.0, 1.0)
    """Shares of the largest turn that either angle of a primitive may be."""
    hold: int = 4
    """Decisions that a primitive lasts."""
    every: int = 4
    """Decisions flown before the next search."""
    nodes: int = 300
    """No more are expanded in one search."""
    seconds: float | None = None
    """Nor is a search longer than this; None for no limit. With one, flights need not repeat."""
    sight_m: float = 40.0
    """How far ahead of the start the search goes."""
    merge_m: float = 1.0
    """Nodes of one heading that lie in the same cube of this width are one."""
    berth_m: float = 0.05
    """Metres kept from every ball beyond what is needed."""
    clock: Callable[[], float] = time.perf_counter
    watch: Callable[[Plan], None] | None = None
    """Told every plan; for measuring."""

    def __post_init__(self) -> None:
        for entry, least in (("hold", 1), ("every", 1), ("nodes", 1)):
            if not isinstance(getattr(self, entry), int) or getattr(self, entry) < least:
                raise InvalidInputError(
                    f"A* was given {entry}={getattr(self, entry)!r}; it must be a whole number "
                    "from 1 on."
                )
        if not self.levels or not all(-1.0 <= level <= 1.0 for level in self.levels):
            raise InvalidInputError(
                f"A* was given levels={self.levels!r}; give shares of a full turn, -1 to 1."
            )

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        scene.course(scene.worlds(seeds[:1]))  # says so where there is none
        return {
            "plan": np.zeros((len(seeds), self.every, 2)),
            "left": np.zeros(len(seeds), dtype=np.int64),
        }

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        plans, left = memory["plan"].copy(), memory["left"].copy()
        course = scene.course(snapshot)
        for world in np.flatnonzero(left == 0):
            plan = self.plan(scene, course, int(world))
            if self.watch is not None:
                self.watch(plan)
            found = plan.actions[: self.every]
            left[world] = max(1, len(found))
            # The plan stands at the end, so that `left` counts what is still to do.
            plans[world] = 0.0
            plans[world, self.every - len(found) :] = found
        actions = plans[np.arange(len(plans)), self.every - left]
        return actions, {"plan": plans, "left": left - 1}

    def plan(self, scene: Scene, course: Course, world: int) -> Plan:
        """The quickest way found from where `world` of the `course` is now."""
        from evastudio.pilots.kernels import best_first as search  # numba loads slowly

        start, balls = course.position[world], course.balls[world]
        moves = _primitives(self.levels, scene)
        most = self.nodes * len(moves) + 1
        nodes = np.empty((most, search.COLUMNS))
        links = np.empty((most, search.LINKS), dtype=np.int32)
        heap = np.empty(most, dtype=np.int32)
        entries = 1 << (2 * most).bit_length() if self.merge_m > 0.0 else 1
        table = np.full(entries, -1, dtype=np.int32)
        places = np.empty((entries, 5), dtype=np.int32)
        counts = np.zeros(search.COUNTS, dtype=np.int64)
        reach = course.reach + self.berth_m
        goal = min(course.length, start[0] + self.sight_m)
        # Cubes around all places that can be reached; farther balls cannot be touched.
        around = self.sight_m / np.cos(course.steepest) ** 2 + reach
        low = start - (4.0 * reach, around, around)
        size = 2.0 * reach
        high = np.array([goal, *(start[1:] + around)]) + 4.0 * reach
        shape = np.ceil((high - low) / size).astype(np.int64)
        heads = np.empty(int(shape.prod()), dtype=np.int32)
        following = np.empty(len(balls), dtype=np.int32)
        search.list_balls(balls, low, size, shape, heads, following)
        nodes[0] = (*start, *course.heading[world], 0.0, 0.0)
        links[0] = (-1, -1, 0)
        heap[0] = 0
        counts[[search.NODES, search.WAITING, search.GOAL]] = 1, 1, -1
        began = self.clock() if self.seconds is not None else 0.0
        limit = 0
        while limit < self.nodes:
            limit = self.nodes if self.seconds is None else min(limit + SLICE, self.nodes)
            search.expand(
                *(nodes, links, heap, table, places, counts, limit),
                *(balls, low, size, shape, heads, following),
                *(moves, self.hold, course.speed * scene.dt_s, scene.dt_s, reach),
                *(course.half_width, course.steepest, goal, self.merge_m, np.radians(3.0)),
            )
            ended = counts[search.GOAL] >= 0 or counts[search.WAITING] == 0
            if ended or (self.seconds is not None and self.clock() - began >= self.seconds):
                break
        finished = bool(counts[search.GOAL] >= 0)
        last = int(counts[search.GOAL] if finished else counts[search.FARTHEST])
        made = int(counts[search.NODES])
        a_node = nodes.itemsize * search.COLUMNS + links.itemsize * search.LINKS
        noted = int((table >= 0).sum()) * (table.itemsize + 5 * places.itemsize)
        return Plan(
            actions=_way_to(last, moves, links),
            cost_s=float(nodes[last, search.COST]),
            finished=finished,
            expanded=int(counts[search.EXPANDED]),
            stored_bytes=made * (a_node + heap.itemsize) + noted,
        )


def _primitives(levels: Sequence[float], scene: Scene) -> Array:
    """The turns of each primitive, rad, shape (primitives, 2), the smallest first."""
    pairs = sorted(itertools.product(levels, repeat=2), key=lambda pair: sum(x * x for x in pair))
    return np.ascontiguousarray(np.array(pairs) * scene.action.high)


def _way_to(node: int, moves: Array, links: NDArray[np.int32]) -> Array:
    """The actions that lead to `node`, in order."""
    parts = []
    while node > 0:
        before, move, ways = links[node]
        parts.append(np.repeat(moves[move][None], ways - links[before, 2], axis=0))
        node = int(before)
    return np.concatenate(parts[::-1]) if parts else np.zeros((0, moves.shape[1]))
