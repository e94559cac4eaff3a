"""From recordings of people walking to takes: everybody's way once more, through a scene's step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED
from evastudio.demonstrations.walks import Walks
from evastudio.errors import InvalidInputError
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

SIGHT_M = 5.0
"""Who never comes nearer than this to the lead is left out of its take."""
MOST_OTHERS = 29
"""Of those who do, so many at most, the nearest."""
SHORTEST_M = 3.0
"""Who ends up nearer to where they began goes nowhere, and leads no take."""
SHORTEST = 8
"""Steps that a lead is seen at least."""
LONGEST = 2000
"""Steps of a take at most: who is there for longer is standing about."""
TRODDEN_M = 0.1
"""Metres between the points that tell where people walked."""


@dataclass(frozen=True)
class Stepped:
    """A recording at a scene's decision step."""

    first: NDArray[np.int64]
    """The step in which each person is first seen, shape (people,)."""
    places: tuple[Array, ...]
    """Of each from then on, metres, shape (steps, 2)."""
    dt_s: float

    @property
    def goals(self) -> Array:
        """Where each is last seen, shape (people, 2)."""
        return np.array([places[-1] for places in self.places])

    def between(self, people: NDArray[np.int64], start: int, stop: int) -> Array:
        """Where `people` are from step `start` to before `stop`, (steps, people, 2), else NaN."""
        found = np.full((stop - start, len(people), 2), np.nan)
        for column, person in enumerate(people):
            begins = int(self.first[person])
            low, high = max(begins, start), min(begins + len(self.places[person]), stop)
            if low < high:
                found[low - start : high - start, column] = self.places[person][
                    low - begins : high - begins
                ]
        return found

    def travellers(self) -> NDArray[np.int64]:
        """The people who go somewhere, in the order in which they come."""
        going = [
            person
            for person, places in enumerate(self.places)
            if SHORTEST <= len(places) <= LONGEST
            and np.hypot(*(places[-1] - places[0])) >= SHORTEST_M
        ]
        chosen = np.array(going, dtype=np.int64)
        return chosen[np.argsort(self.first[chosen], kind="stable")]

    def beside(
        self, lead: int, start: int, stop: int, most: int = MOST_OTHERS
    ) -> NDArray[np.int64]:
        """Who comes within sight of `lead` between two steps, at most `most`, the nearest first."""
        own = self.between(np.array([lead]), start, stop)
        lasts = self.first + [len(places) for places in self.places]
        there = np.flatnonzero((self.first < stop - 1) & (lasts > start + 1))
        there = there[there != lead]
        apart = self.between(there, start, stop) - own
        far = np.hypot(apart[..., 0], apart[..., 1])
        nearest = np.nanmin(np.where(np.isnan(far), np.inf, far), axis=0, initial=np.inf)
        near = np.argsort(nearest, kind="stable")[:most]
        return np.asarray(there[near[nearest[near] <= SIGHT_M]])


def at_step(walks: Walks, dt_s: float) -> Stepped:
    """`walks` at every `dt_s` seconds. Raises InvalidInputError where nobody is seen twice."""
    stepped = [walk.every(dt_s) for walk in walks.people]
    kept = [(first, places) for first, places in stepped if len(places) >= 3]
    if not kept:
        raise InvalidInputError(
            f"{walks.name!r} shows nobody for as long as {2 * dt_s:g} s; nothing can be learned."
        )
    first = np.array([first for first, _ in kept], dtype=np.int64)
    return Stepped(first, tuple(places for _, places in kept), dt_s)


@dataclass(frozen=True)
class Retraced:
    """A scene's world in which everybody can go as they were recorded."""

    scene: Scene
    start: Snapshot
    """Of one world; the first of its characters leads."""
    actions: Array
    """What everybody did, shape (steps, characters, action size)."""

    def moments(self) -> Iterator[tuple[Snapshot, Array]]:
        """The moments while the lead is on its way, and what all did in each."""
        moment = self.start
        for action in self.actions:
            if self.scene.outcome(moment)[0] != 0:
                return
            yield moment, action[None]
            moment = self.scene.step(moment, action[None])


def retrace(
    make: Callable[..., Scene],
    stepped: Stepped,
    people: NDArray[np.int64],
    start: int,
    stop: int,
    ground: Array,
) -> Retraced:
    """The world of `people`, the lead first, between two steps of the recording.

    The step `start` gives velocities alone. `make` is the scene's class, `ground` (points, 2) is
    where people are known to walk. Raises NotFoundError where the scene cannot retrace.
    """
    paths = stepped.between(people, start, stop)
    options = {
        "people": float(len(people)),
        "size": float(np.ceil(max(16.0, np.sqrt(len(people)) + 1.0))),
        "length": float(min(3600.0, 5.0 * np.ceil((stop - start) * stepped.dt_s / 5.0 + 1.0))),
    }
    scene = make(**options)
    first, actions = scene.retraced(paths, stepped.goals[people], ground)
    return Retraced(scene, first, actions)


def trodden(stepped: Stepped) -> tuple[Array, ...]:
    """Points along the way of each person, (points, 2), TRODDEN_M apart."""
    parts = []
    for places in stepped.places:
        along = np.hypot(*np.diff(places, axis=0).T)
        way = np.concatenate([[0.0], along.cumsum()])
        at = np.arange(0.0, way[-1] + TRODDEN_M, TRODDEN_M)
        parts.append(np.column_stack([np.interp(at, way, axis) for axis in places.T]))
    return tuple(parts)


def elsewhere(parts: Sequence[Array], person: int) -> Array:
    """The points of all but `person`, so that nobody's own way is told beforehand."""
    return np.concatenate([np.empty((0, 2)), *parts[:person], *parts[person + 1 :]])


def record_retraced(recorder: Recorder, retraced: Retraced, pilot: str, now: float) -> int:
    """Write one take; how many pairs it has."""
    scene = retraced.scene
    view = scene.perception()
    recorder.begin(scene, retraced.start, RECORDED, pilot, now)
    pairs = 0
    for moment, actions in retraced.moments():
        recorder.add(of_lead(moment, view.perceive(moment).states), actions, moment)
        pairs += 1
    recorder.end(scene.outcomes[1], now)
    return pairs
