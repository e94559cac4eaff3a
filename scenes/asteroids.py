"""A spaceship crosses a field of asteroids: section 4.1 of the paper.

The ship flies at constant speed; the action turns it. Everything is in metres, seconds and
radians; x leads through the field, y to the left, z up.

| state of a world | shape      | meaning                                                      |
|------------------|------------|--------------------------------------------------------------|
| rocks            | (N, 3)     | centres of the asteroids, sorted by x; fixed                 |
| slabs            | (S,)       | number of rocks before each 5 m of x; fixed                  |
| position         | (3,)       | centre of the ship                                           |
| heading          | (2,)       | yaw theta and pitch phi, each within 60 degrees of straight  |
| turn             | (2,)       | the change of heading in the last step, for the look of it   |
| steps            | ()         | decisions so far                                             |

A world ends when the ship crosses the far plane, touches a rock, leaves the corridor or has
taken 90 s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.geometry import directions, quaternions_from_euler
from evastudio.world.scene import Control, Option, Percept, Perception, Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box, Field

LENGTH = 360.0
SPEED = 10.0
SHIP_RADIUS = 1.0
ROCK_RADIUS = 3.0
CLEAR = 25.0
"""The first metres hold no rocks."""
MARGIN = 10.0
"""Rocks lie this far outside the corridor too, so that its walls are no refuge."""
TURN = np.radians(6.0)
"""Largest change of each angle in one decision."""
HEADING = np.radians(60.0)
"""Largest yaw and pitch: the ship cannot turn back."""
TIME_LIMIT_S = 90.0
SLAB = 5.0
SLABS = int(LENGTH / SLAB)
SIGHT = 60.0
"""Rocks farther ahead are not perceived."""
REACH = ROCK_RADIUS + SHIP_RADIUS
FAR_AWAY = 1e6


class Asteroids(Scene):
    """See the module's docstring."""

    name = "asteroids"
    title = "Asteroid field"
    version = 1
    dt_s = 1.0 / 15.0
    render_hz = 60.0
    outcomes = ("running", "crossed", "hit", "left", "late")
    successes = frozenset({"crossed"})
    options = (
        Option(
            "density",
            "Rocks in the way",
            4.0,
            0.1,
            10.0,
            0.1,
            "Expected number of hits of a ship that flies straight ahead.",
        ),
        Option(
            "half_width",
            "Half the corridor's width (m)",
            100.0,
            30.0,
            150.0,
            5.0,
            "The ship is lost when it strays farther than this from the middle.",
        ),
    )
    controls = (
        Control("theta", "turn left or right", ("KeyD", "ArrowRight"), ("KeyA", "ArrowLeft"), 0.3),
        Control("phi", "climb or dive", ("KeyS", "ArrowDown"), ("KeyW", "ArrowUp"), 0.3),
    )
    action = Box((Field("theta", "rad", -TURN, TURN), Field("phi", "rad", -TURN, TURN)))
    look = Look(
        background=(13, 16, 32),
        fog_near=40.0,
        fog_far=210.0,
        sun_direction=(-0.4, 0.5, 0.75),
    )

    def __init__(self, **values: float) -> None:
        super().__init__(**values)
        views: tuple[Perception, ...] = (Canonical(), PaperState())
        self.perceptions = {view.name: view for view in views}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        half = self.values["half_width"] + MARGIN
        count = max(1, round(self.values["density"] * (2 * half) ** 2 / (np.pi * REACH**2)))
        rocks = rng.uniform((CLEAR, -half, -half), (LENGTH, half, half), (worlds, count, 3))
        rocks = np.take_along_axis(rocks, np.argsort(rocks[:, :, :1], axis=1), axis=1)
        edges = np.arange(SLABS + 1) * SLAB
        slabs = np.stack([np.searchsorted(world[:, 0], edges) for world in rocks])
        slabs[:, -1] = count
        return Snapshot(
            {"rocks": rocks, "slabs": slabs.astype(np.int64)},
            {
                "position": np.zeros((worlds, 3)),
                "heading": np.zeros((worlds, 2)),
                "turn": np.zeros((worlds, 2)),
                "steps": np.zeros(worlds, dtype=np.int64),
            },
        )

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        before = snapshot["heading"]
        heading = np.clip(before + self.action.clip(actions), -HEADING, HEADING)
        return snapshot.after(
            position=snapshot["position"] + directions(heading) * (SPEED * self.dt_s),
            heading=heading,
            turn=heading - before,
            steps=snapshot["steps"] + 1,
        )

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        position = snapshot["position"]
        near, present = rocks_between(snapshot, -REACH, REACH)
        hit = (present & ((near**2).sum(axis=2) < REACH**2)).any(axis=1)
        left = (np.abs(position[:, 1:]) > self.values["half_width"]).any(axis=1)
        late = snapshot["steps"] * self.dt_s >= TIME_LIMIT_S
        crossed = position[:, 0] >= LENGTH
        return np.select([hit, left, crossed, late], [2, 3, 1, 4], default=0)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.asarray(np.clip(snapshot["position"][:, 0] / LENGTH, 0.0, 1.0))

    def intention(
        self,
        snapshot: Snapshot,
        *,
        berth: float = 6.0,
        reach: float = 22.0,
        strength: float = 0.30,
        homing: float = 0.12,
        **_: float,
    ) -> Array:
        """Turn away from what is in the way, else back to straight ahead.

        berth: metres kept between the ship's hull and a rock.
        reach: metres ahead over which a rock's push fades to a third.
        strength: turn per step, rad, that a rock dead ahead at the hull asks for.
        homing: share of the heading taken back per step where nothing is in the way.
        """
        threats, present = worst_threats(snapshot, 8)
        ahead, lateral = threats[:, :, 0], threats[:, :, 1:]
        aside = np.sqrt((lateral**2).sum(axis=2))
        closeness = np.clip(1.0 - (aside - REACH) / berth, 0.0, 1.0) * np.exp(-ahead / reach)
        push = np.where(present, closeness, 0.0) * strength
        away = -lateral / np.maximum(aside, 1e-9)[:, :, None]
        turn = (push[:, :, None] * away).sum(axis=1)
        return self.action.clip(turn - homing * snapshot["heading"])

    # -- what it looks like --------------------------------------------------------------------

    def meshes(self) -> Mapping[str, Mesh]:
        return {**rock_meshes(), **ship_meshes()}

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        rocks = snapshot["rocks"][0]
        spin = np.random.default_rng(len(rocks)).uniform(-np.pi, np.pi, (len(rocks), 3))
        wxyzs = quaternions_from_euler(spin[:, 0], spin[:, 1], spin[:, 2])
        bodies = [
            Body(
                name,
                name,
                rocks[kind :: len(ROCKS)],
                wxyzs[kind :: len(ROCKS)],
                np.full(len(rocks[kind :: len(ROCKS)]), ROCK_RADIUS),
                fixed=True,
            )
            for kind, name in enumerate(ROCKS)
        ]
        theta, phi = snapshot["heading"][0]
        bank = -snapshot["turn"][0, 0] / TURN * np.radians(35.0)
        pose = quaternions_from_euler(np.array([bank]), np.array([-phi]), np.array([theta]))
        ship = snapshot["position"][:1]
        return [*bodies, *(Body(name, name, ship, pose, np.ones(1)) for name in SHIP)]

    def camera(self, snapshot: Snapshot) -> Camera:
        heading = snapshot["heading"][:1] * 0.8
        forward = directions(heading)[0]
        ship = snapshot["position"][0]
        return Camera(
            position=ship - forward * 13.0 + np.array([0.0, 0.0, 3.6]),
            look_at=ship + forward * 14.0,
            up=np.array([0.0, 0.0, 1.0]),
        )


# -- perceptions -------------------------------------------------------------------------------


class PaperState(Perception):
    """Exactly the paper's: orientation, and the separations from the two nearest asteroids."""

    name = "paper"
    summary = "The paper's own: where the ship points, and the two nearest rocks on any side."
    state = Box(
        (
            Field("theta", "rad", -HEADING, HEADING),
            Field("phi", "rad", -HEADING, HEADING),
            *(
                Field(f"{axis}{rock}", "m", -np.inf, np.inf)
                for rock in (1, 2)
                for axis in ("dx", "dy", "dz")
            ),
        )
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        # The two nearest within sight are the two nearest of all, unless fewer are in sight.
        near, present = rocks_between(snapshot, -SIGHT, SIGHT)
        square = np.where(present, (near**2).sum(axis=2), np.inf)
        index = smallest(square, 2)
        found = np.take_along_axis(square, index, axis=1) < np.inf
        separation = np.take_along_axis(-near, index[:, :, None], axis=1)
        separation = np.where(found[:, :, None], separation, SIGHT)
        states = np.concatenate(
            [snapshot["heading"], separation.reshape(len(separation), 6)], axis=1
        )
        return Percept(states, np.zeros((len(states), 0)))


class Canonical(Perception):
    """The two greatest threats ahead, seen from the ship and rolled into one standard view.

    The view is rolled about the ship's axis until the greatest threat lies on the first lateral
    axis, and mirrored until the second lies on the positive side. Left and right, above and
    below become one case, so one demonstration teaches all four, and the conflict of passing a
    rock dead ahead on this side or that does not arise. Threats fade with their distance.
    """

    name = "canonical"
    summary = "The two greatest threats ahead, rolled so that left, right, up and down are one."
    state = Box(
        (
            Field("threat1_ahead", "1", 0.0, 1.0),
            Field("threat1_aside", "1", 0.0, 1.0),
            Field("threat2_ahead", "1", 0.0, 1.0),
            Field("threat2_aside", "1", -1.0, 1.0),
            Field("threat2_across", "1", 0.0, 1.0),
            Field("heading_aside", "rad", -2 * HEADING, 2 * HEADING),
            Field("heading_across", "rad", -2 * HEADING, 2 * HEADING),
        )
    )
    fade = 4.0
    """Metres of clear distance over which a threat fades to a third."""

    def perceive(self, snapshot: Snapshot) -> Percept:
        threats, present = worst_threats(snapshot, 2)
        distance = np.sqrt((threats**2).sum(axis=2))
        nearness = np.exp(-np.maximum(distance - REACH, 0.0) / self.fade)
        seen = threats * np.where(present, nearness / np.maximum(distance, 1e-9), 0.0)[:, :, None]
        heading = snapshot["heading"]
        # Roll so that the first threat, or else the heading, lies on the first lateral axis.
        guide = np.where(present[:, :1], threats[:, 0, 1:], heading)
        length = np.sqrt((guide**2).sum(axis=1, keepdims=True))
        one = np.where(length > 1e-9, guide / np.maximum(length, 1e-9), (1.0, 0.0))
        two = np.stack([-one[:, 1], one[:, 0]], axis=1)
        across = (seen[:, 1, 1:] * two).sum(axis=1)
        across = np.where(np.abs(across) > 1e-12, across, (heading * two).sum(axis=1))
        two = two * np.where(across < 0.0, -1.0, 1.0)[:, None]
        frame = np.stack([one, two], axis=1)
        aside = turned(frame, seen[:, 0, 1:])
        other = turned(frame, seen[:, 1, 1:])
        states = np.concatenate(
            [seen[:, 0, :1], aside[:, :1], seen[:, 1, :1], other, turned(frame, heading)], axis=1
        )
        return Percept(states, frame)

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        return turned(frame, actions)

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        return turned(np.swapaxes(frame, 1, 2), actions)


def turned(frames: AnyArray, vectors: Array) -> Array:
    """`vectors` (worlds, 2) multiplied by `frames` (worlds, 2, 2)."""
    return np.asarray((frames * vectors[:, None, :]).sum(axis=2))


def rocks_between(snapshot: Snapshot, low: float, high: float) -> tuple[Array, NDArray[np.bool_]]:
    """Rocks whose x lies between `low` and `high` of the ship's, and up to a slab more.

    Returns vectors from the ship, shape (worlds, K, 3), and which of the K are rocks at all.
    """
    rocks, slabs = snapshot["rocks"], snapshot["slabs"]
    position = snapshot["position"]
    world = np.arange(len(rocks))
    first = np.clip(np.floor((position[:, 0] + low) / SLAB), 0, SLABS).astype(np.int64)
    last = np.clip(np.ceil((position[:, 0] + high) / SLAB), 0, SLABS).astype(np.int64)
    start, stop = slabs[world, first], slabs[world, last]
    index = start[:, None] + np.arange(max(1, int((stop - start).max())))
    present = index < stop[:, None]
    index = np.minimum(index, rocks.shape[1] - 1)
    return rocks[world[:, None], index] - position[:, None, :], present


def worst_threats(snapshot: Snapshot, count: int) -> tuple[Array, NDArray[np.bool_]]:
    """The rocks that most endanger the ship, worst first.

    A threat counts by its distance ahead plus 2.5 times its clearance to the side; nothing
    behind is one. Returns vectors in the ship's frame (forward, left, up), shape
    (worlds, count, 3), and which of them exist.
    """
    near, present = rocks_between(snapshot, -SLAB, SIGHT)
    forward, left, up = ship_axes(snapshot["heading"])
    ahead, aside, above = (
        near[:, :, 0] * axis[:, None, 0]
        + near[:, :, 1] * axis[:, None, 1]
        + near[:, :, 2] * axis[:, None, 2]
        for axis in (forward, left, up)
    )
    lateral = np.sqrt(aside**2 + above**2)
    menace = np.maximum(ahead - ROCK_RADIUS / 2, 0.0) + 2.5 * np.maximum(lateral - ROCK_RADIUS, 0.0)
    menace = np.where(present & (ahead > 0.0), menace, np.inf)
    index = smallest(menace, count)
    exists = np.take_along_axis(menace, index, axis=1) < SIGHT
    threats = np.stack(
        [np.take_along_axis(values, index, axis=1) for values in (ahead, aside, above)], axis=2
    )
    return np.where(exists[:, :, None], threats, (FAR_AWAY, 0.0, 0.0)), exists


def smallest(values: Array, count: int) -> NDArray[np.int64]:
    """Columns of the `count` smallest values of each row, in order; the last repeats if too few."""
    kept = min(count, values.shape[1])
    index = np.argpartition(values, kept - 1, axis=1)[:, :kept]
    order = np.argsort(np.take_along_axis(values, index, axis=1), axis=1, kind="stable")
    index = np.take_along_axis(index, order, axis=1)
    return np.pad(index, ((0, 0), (0, count - kept)), mode="edge")


def ship_axes(heading: Array) -> tuple[Array, Array, Array]:
    """Forward, left and up of ships with `heading` (worlds, 2), each of shape (worlds, 3)."""
    cos_t, sin_t = np.cos(heading[:, 0]), np.sin(heading[:, 0])
    cos_p, sin_p = np.cos(heading[:, 1]), np.sin(heading[:, 1])
    zero = np.zeros(len(heading))
    return (
        np.stack([cos_p * cos_t, cos_p * sin_t, sin_p], axis=1),
        np.stack([-sin_t, cos_t, zero], axis=1),
        np.stack([-sin_p * cos_t, -sin_p * sin_t, cos_p], axis=1),
    )


# -- meshes ------------------------------------------------------------------------------------

ROCKS: tuple[str, ...] = ("rock_a", "rock_b", "rock_c")
SHIP: tuple[str, ...] = ("hull", "canopy", "wings", "flame")


def rock_meshes() -> dict[str, Mesh]:
    """Three low, cratered boulders of radius 1, within the sphere that collides."""
    colors: Sequence[tuple[int, int, int]] = ((132, 120, 112), (112, 106, 110), (146, 124, 104))
    meshes: dict[str, Mesh] = {}
    for number, (name, color) in enumerate(zip(ROCKS, colors, strict=True)):
        rng = np.random.default_rng(number)
        ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
        points = np.asarray(ball.vertices, dtype=np.float64)
        bumps = rng.normal(size=(14, 3))
        bumps /= np.linalg.norm(bumps, axis=1, keepdims=True)
        dents = np.exp(-((1.0 - points @ bumps.T) / 0.12)) * rng.uniform(0.05, 0.3, 14)
        radius = np.clip(1.04 - dents.sum(axis=1), 0.6, 1.0) * rng.uniform(0.96, 1.0, len(points))
        meshes[name] = Mesh(
            points * radius[:, None], np.asarray(ball.faces, dtype=np.int64), color, flat=True
        )
    return meshes


def ship_meshes() -> dict[str, Mesh]:
    """A small dart: hull, glass, wings and engine flame, about 3 m long."""

    def loft(rings: Sequence[tuple[float, float, float, float]], sides: int) -> trimesh.Trimesh:
        """A closed hull through rings of (x, half width, half height, z)."""
        angle = np.arange(sides) * 2 * np.pi / sides
        points = [
            (x, wide * np.cos(a), z + high * np.sin(a)) for x, wide, high, z in rings for a in angle
        ]
        hull: trimesh.Trimesh = trimesh.convex.convex_hull(np.array(points))
        return hull

    def mesh(shape: trimesh.Trimesh, color: tuple[int, int, int], glow: bool = False) -> Mesh:
        return Mesh(
            np.asarray(shape.vertices, dtype=np.float64),
            np.asarray(shape.faces, dtype=np.int64),
            color,
            flat=not glow,
            glow=glow,
        )

    hull = loft([(1.9, 0.05, 0.04, -0.05), (0.4, 0.42, 0.3, 0.0), (-1.2, 0.5, 0.34, 0.0)], 8)
    canopy = loft([(0.8, 0.08, 0.05, 0.2), (0.2, 0.24, 0.22, 0.25), (-0.5, 0.16, 0.12, 0.3)], 6)
    wing = np.array([(0.3, 0.3, 0.0), (-1.3, 0.3, 0.0), (-1.5, 1.5, -0.15), (-1.0, 1.5, -0.15)])
    thick = np.array([0.0, 0.0, 0.09])
    sides = []
    for side in (1.0, -1.0):
        flat = wing * (1.0, side, 1.0)
        sides.append(trimesh.convex.convex_hull(np.concatenate([flat, flat + thick])))
    wings: trimesh.Trimesh = trimesh.util.concatenate(sides)
    flame = loft([(-1.2, 0.26, 0.2, 0.0), (-1.8, 0.18, 0.14, 0.0), (-2.9, 0.02, 0.02, 0.0)], 8)
    return {
        "hull": mesh(hull, (226, 230, 238)),
        "canopy": mesh(canopy, (64, 180, 232)),
        "wings": mesh(wings, (236, 98, 62)),
        "flame": mesh(flame, (255, 190, 96), glow=True),
    }


SCENE: type[Scene] = Asteroids
