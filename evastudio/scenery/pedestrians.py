"""What pedestrians see of where they go and of each other, and how they decide to move.

Worlds of pedestrians hold `position`, `velocity` (N, 2), `heading`, `leg`, `present` (N,) and
`goals` (N, K, 2), see `scenes/street.py`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.scenery.free_ground import FEELS, clearances
from evastudio.world.cast import of_lead
from evastudio.world.scene import Percept, Perception
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box, Field, Space

MOST = 3.0
"""Metres a second, ahead or sideways."""
TURN = 1.6
"""Radians that one can turn in a step."""
WALKS = 0.5
"""Metres a second from which on one faces the way one walks; who goes slower turns less."""
SEEN = 3
"""People that are perceived."""
FADE = 2.0
"""Metres over which the weight of a person seen falls to 1/e."""
BEHIND = 0.3
"""Who is farther behind than this is not perceived."""
FARTHEST = 5.0
"""Metres; goals beyond are as far as this."""


def near(number: int) -> tuple[Field, ...]:
    """The fields of one person seen."""
    return (
        Field(f"near_ahead{number}", "1", -1.0, 1.0),
        Field(f"near_left{number}", "1", -1.0, 1.0),
        Field(f"passing_ahead{number}", "m/s", -3 * MOST, 3 * MOST),
        Field(f"passing_left{number}", "m/s", -3 * MOST, 3 * MOST),
    )


class Goal(Perception):
    """The way to the goal, the own velocity and the nearest people ahead.

    Directions are those of the goal. A person seen is a direction and a relative velocity, both
    fading with distance. What is chosen is the change of velocity, and one faces the way one goes.
    """

    name = "goal"
    summary = "How one walks towards the goal, and the three nearest people ahead."
    relative = True
    """Others' velocities are seen from one's own."""
    action: Space | None = Box(
        (
            Field("change_ahead", "m/s", -2 * MOST, 2 * MOST),
            Field("change_left", "m/s", -2 * MOST, 2 * MOST),
        )
    )
    state = Box(
        (
            Field("speed_ahead", "m/s", -2 * MOST, 2 * MOST),
            Field("speed_left", "m/s", -2 * MOST, 2 * MOST),
            Field("goal", "m", 0.0, FARTHEST),
            *(field for number in range(1, SEEN + 1) for field in near(number)),
        )
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        way = goal_of(snapshot) - snapshot["position"]
        bearing = np.arctan2(way[..., 1], way[..., 0])
        velocity = snapshot["velocity"]
        own = turned(velocity, -bearing)
        distance = np.minimum(np.hypot(way[..., 0], way[..., 1]), FARTHEST)
        others = nearest(snapshot, bearing, SEEN)
        far = np.maximum(np.hypot(others.apart[..., 0], others.apart[..., 1]), 0.05)[..., None]
        fade = np.exp(-far / FADE) * others.seen[..., None]
        towards = turned(others.apart, -bearing[..., None]) / far * fade
        base = velocity[:, :, None] if self.relative else 0.0
        passing = turned(others.velocity - base, -bearing[..., None]) * fade
        people = np.concatenate([towards, passing], axis=3).reshape(*bearing.shape, -1)
        seen = [own] if self.relative else []
        states = np.concatenate([*seen, distance[..., None], people], axis=2)
        heading = snapshot["heading"]
        frame = np.concatenate([velocity, bearing[..., None], heading[..., None]], axis=2)
        return Percept(states, frame)

    def applies(self, snapshot: Snapshot) -> NDArray[np.bool_]:
        return np.asarray(of_lead(snapshot, snapshot["present"]) > 0)

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        velocity = turned(actions[..., 1:], frame[..., 3] + actions[..., 0])
        return turned(velocity - frame[..., :2], -frame[..., 2])

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        velocity = frame[..., :2] + turned(actions, frame[..., 2])
        return moves(frame[..., 3], velocity)


class Flow(Goal):
    """The goal and the nearest people ahead with how they walk, and not how one walks oneself.

    What is chosen is the velocity. Whoever sees their own speed learns above all to keep it, and
    once slow stays so; this one has none to keep.
    """

    name = "flow"
    summary = "The goal, and where and how the three nearest people ahead walk; not one's own pace."
    action = Box(
        (
            Field("velocity_ahead", "m/s", -2 * MOST, 2 * MOST),
            Field("velocity_left", "m/s", -2 * MOST, 2 * MOST),
        )
    )
    state = Box(Goal.state.fields[2:])
    relative = False

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        return turned(actions[..., 1:], frame[..., 3] + actions[..., 0] - frame[..., 2])

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        return moves(frame[..., 3], turned(actions, frame[..., 2]))


class Walls(Goal):
    """The same, and how far the ground goes on ahead and to the sides."""

    name = "walls"
    summary = "The goal, the three nearest people ahead, and how much ground is free."
    state = Box(
        (
            *Goal.state.fields,
            *(
                Field(f"free_{way}", "m", 0.0, float(FEELS[-1]))
                for way in ("ahead", "half_left", "half_right", "left", "right")
            ),
        )
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        seen = super().perceive(snapshot)
        free = clearances(snapshot, seen.frame[..., 2])
        return Percept(np.concatenate([seen.states, free], axis=2), seen.frame)


class Others:
    """The people that everybody sees."""

    def __init__(self, apart: Array, velocity: Array, seen: Array) -> None:
        self.apart = apart
        """From the one who sees, metres, shape (worlds, N, count, 2)."""
        self.velocity = velocity
        """Metres a second, the same shape."""
        self.seen = seen
        """1, or 0 where there is nobody, shape (worlds, N, count)."""


def nearest(snapshot: Snapshot, facing: Array, count: int) -> Others:
    """The `count` nearest who are there and not behind one that looks along `facing` (worlds, N).

    World by world, so that memory holds the pairs of one.
    """
    position, velocity = snapshot["position"], snapshot["velocity"]
    worlds, people = facing.shape
    apart = np.zeros((worlds, people, count, 2))
    moving = np.zeros_like(apart)
    seen = np.zeros((worlds, people, count))
    kept = min(count, people - 1)
    if kept < 1:
        return Others(apart, moving, seen)
    rows = np.arange(people)[:, None]
    for world in range(worlds):
        away = position[world, None] - position[world, :, None]
        ahead = away[..., 0] * np.cos(facing[world])[:, None]
        ahead += away[..., 1] * np.sin(facing[world])[:, None]
        far = np.hypot(away[..., 0], away[..., 1])
        far[(ahead < -BEHIND) | (snapshot["present"][world] == 0)] = np.inf
        np.fill_diagonal(far, np.inf)
        some = np.argpartition(far, kept - 1, axis=1)[:, :kept]
        order = np.argsort(far[rows, some], axis=1, kind="stable")
        who = some[rows, order]
        apart[world, :, :kept] = away[rows, who]
        moving[world, :, :kept] = velocity[world, who]
        seen[world, :, :kept] = np.isfinite(far[rows, who])
    return Others(apart, moving, seen)


def goal_of(snapshot: Snapshot) -> Array:
    """Where everybody goes now, (worlds, N, 2)."""
    goals = snapshot["goals"]
    leg = snapshot["leg"] % goals.shape[2]
    return np.asarray(np.take_along_axis(goals, leg[..., None, None], axis=2)[:, :, 0])


def turned(vectors: Array, angle: Array) -> Array:
    """`vectors` (..., 2) turned left by `angle` (...)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def moves(heading: Array, velocity: Array) -> Array:
    """The actions (..., 3) of those who face `heading` (...) and go on at `velocity` (..., 2)."""
    way = np.arctan2(velocity[..., 1], velocity[..., 0]) - heading
    way = np.remainder(way + np.pi, 2 * np.pi) - np.pi
    sure = np.minimum(np.hypot(velocity[..., 0], velocity[..., 1]) / WALKS, 1.0)
    turn = np.clip(way * sure, -TURN, TURN)
    return np.concatenate([turn[..., None], turned(velocity, -heading - turn)], axis=-1)
