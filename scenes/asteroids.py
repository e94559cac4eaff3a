"""A spaceship crosses a field of asteroids: section 4.1 of the paper.

The ship flies at constant speed; the action turns it. Everything is in metres, seconds and
radians; x leads through the field, y to the left, z up.

| state of a world | shape      | meaning                                                      |
|------------------|------------|--------------------------------------------------------------|
| rocks            | (N, 3)     | centres of the asteroids, sorted cell by cell; fixed         |
| cells            | (C + 1,)   | number of rocks before each cell of the x-y plane; fixed     |
| half             | ()         | the rocks lie this far to the left and right at most; fixed  |
| position         | (3,)       | centre of the ship                                           |
| heading          | (2,)       | yaw theta and pitch phi, each within 60 degrees of straight  |
| turn             | (2,)       | the change of heading in the last step, for the look of it   |
| steps            | ()         | decisions so far                                             |

A world ends when the ship crosses the far plane, touches a rock, leaves the corridor or has
taken 90 s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.course import Course
from evastudio.world.geometry import directions, quaternions_from_euler
from evastudio.world.rocks import (
    MOST,
    in_cells,
    nearest_square,
    rocks_within,
    smallest,
    worst_threats,
)
from evastudio.world.scene import Control, Option, Percept, Perception, Scene, Sign
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
SIGHT = 40.0
"""Rocks farther ahead are not perceived."""
REACH = ROCK_RADIUS + SHIP_RADIUS
FAR_BEHIND, FAR_AHEAD = (-24.0, 0.0, 9.0), (26.0, 0.0, 0.0)
"""Metres from the ship to the camera that sees more of the field, and to where it looks."""


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
    signs = (
        Sign("x", "the way flown", "m"),
        Sign("y", "the distance left of the middle", "m"),
        Sign("z", "the distance above the middle", "m"),
    )
    action = Box((Field("theta", "rad", -TURN, TURN), Field("phi", "rad", -TURN, TURN)))
    look = Look(
        background=(34, 45, 82),
        fog_near=20.0,
        fog_far=165.0,
        sun_direction=(-0.25, 0.8, 0.55),
        sun=3.4,
        sky=1.3,
        sky_color=(120, 150, 230),
        ground_color=(96, 52, 74),
        sun_color=(255, 226, 190),
    )

    def __init__(self, **values: float) -> None:
        super().__init__(**values)
        views: tuple[Perception, ...] = (Canonical(), PaperState())
        self.perceptions = {view.name: view for view in views}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        half = self.values["half_width"] + MARGIN
        count = max(1, round(self.values["density"] * (2 * half) ** 2 / (np.pi * REACH**2)))
        rocks = rng.uniform((CLEAR, -half, -half), (LENGTH, half, half), (worlds, count, 3))
        return Snapshot(
            in_cells(rocks, LENGTH, half),
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
        hit = nearest_square(snapshot, REACH) < REACH**2
        left = (np.abs(position[:, 1:]) > self.values["half_width"]).any(axis=1)
        late = snapshot["steps"] * self.dt_s >= TIME_LIMIT_S
        crossed = position[:, 0] >= LENGTH
        ended = np.where(left, 3, np.where(crossed, 1, np.where(late, 4, 0)))
        return np.where(hit, 2, ended)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.asarray(np.clip(snapshot["position"][:, 0] / LENGTH, 0.0, 1.0))

    def notice(self, snapshot: Snapshot) -> Array:
        return np.asarray(snapshot["position"])

    def clearance(self, snapshot: Snapshot) -> Array:
        """From hull to rock."""
        apart = np.sqrt(nearest_square(snapshot, self.clear_m + REACH)) - REACH
        return np.where(apart <= self.clear_m, apart, np.inf)

    def intention(
        self,
        snapshot: Snapshot,
        *,
        berth: float = 8.0,
        reach: float = 20.0,
        strength: float = 0.3,
        homing: float = 0.12,
        **_: float,
    ) -> Array:
        """Turn away from what is in the way, else back on course.

        berth: metres kept between the ship's hull and a rock.
        reach: metres ahead over which a rock's push fades to a third.
        strength: turn per step, rad, that a rock dead ahead at the hull asks for.
        homing: share of the error of course taken back per step.
        """
        threats, present = threats_to(snapshot)
        ahead, lateral = threats[:, :, 0], threats[:, :, 1:]
        aside = np.sqrt((lateral**2).sum(axis=2))
        closeness = np.clip(1.0 - (aside - REACH) / berth, 0.0, 1.0) * np.exp(-ahead / reach)
        push = np.where(present, closeness, 0.0) * strength
        away = -lateral / np.maximum(aside, 1e-9)[:, :, None]
        turn = total(push[:, :, None] * away)
        return self.action.clip(turn - homing * off_course(snapshot))

    def course(self, snapshot: Snapshot) -> Course:
        return Course(
            balls=snapshot["rocks"],
            reach=REACH,
            position=snapshot["position"],
            heading=snapshot["heading"],
            speed=SPEED,
            steepest=float(HEADING),
            length=LENGTH,
            half_width=self.values["half_width"],
        )

    # -- what it looks like --------------------------------------------------------------------

    def meshes(self) -> Mapping[str, Mesh]:
        return {**rock_meshes(), **ship_meshes(), "mote": mote_mesh()}

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        rocks = snapshot["rocks"][0]
        wxyzs, scales = tumbled(len(rocks))
        kinds = len(ROCKS)
        bodies = [
            Body(name, name, rocks[kind::kinds], wxyzs[kind::kinds], scales[kind::kinds], True)
            for kind, name in enumerate(ROCKS)
        ]
        theta, phi = snapshot["heading"][0]
        ship = snapshot["position"][:1]
        bank = -snapshot["turn"][0, 0] / TURN * np.radians(35.0)
        pose = quaternions_from_euler(np.array([bank]), np.array([-phi]), np.array([theta]))
        flicker = 1.0 + 0.08 * np.sin(ship[:, 0] * 7.0) + 0.06 * np.sin(ship[:, 0] * 17.0)
        parts = [Body(name, name, ship, pose, np.ones(1)) for name in SHIP]
        flames = [Body(name, name, ship, pose, flicker) for name in FLAMES]
        return [*bodies, dust(self.values["half_width"]), *parts, *flames]

    def cameras(self, snapshot: Snapshot) -> Mapping[str, Camera]:
        ship = snapshot["position"][0]
        far = Camera(ship + FAR_BEHIND, ship + FAR_AHEAD, up=np.array([0.0, 0.0, 1.0]))
        return {"chase": self.camera(snapshot), "far": far}

    def camera(self, snapshot: Snapshot) -> Camera:
        forward, _, up = (axis[0] for axis in ship_axes(snapshot["heading"][:1] * 0.8))
        ship = snapshot["position"][0]
        return Camera(
            position=ship - forward * 10.0 + up * 3.2,
            look_at=ship + forward * 20.0 + up * 1.2,
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
        nearest = np.full((snapshot.worlds, 2, 3), -SIGHT)
        left = np.arange(snapshot.worlds)
        for radius in (16.0, 48.0, 2 * LENGTH):
            part = snapshot.take(left)
            reach = np.full((len(left), 3), radius)
            x, y, z, present = rocks_within(part, -reach, reach)
            square = np.where(present, x**2 + y**2 + z**2, np.inf)
            index = smallest(square, 2)
            near = np.stack([np.take_along_axis(axis, index, axis=1) for axis in (x, y, z)])
            square = np.take_along_axis(square, index, axis=1)
            exists = (square < np.inf)[:, :, None]
            nearest[left] = np.where(exists, near.transpose(1, 2, 0), -SIGHT)
            left = left[square[:, 1] > radius**2]
            if len(left) == 0:
                break
        separation = -nearest
        states = np.concatenate(
            [snapshot["heading"], separation.reshape(len(separation), 6)], axis=1
        )
        return Percept(states, np.zeros((len(states), 0)))


class Canonical(Perception):
    """What presses on the ship, seen from it and rolled into one standard view.

    Every rock ahead presses sideways on the ship with a weight that fades with its distance
    ahead and with its clearance to the side. The view is rolled about the ship's axis until the
    sum of that pressure lies on the first lateral axis, and mirrored until the error of course
    lies on the positive side of the second. Left and right, above and below become one case, so
    one demonstration teaches all four, and the conflict of passing a rock on this side or that
    does not arise. Beside the sum, the greatest threat is seen on its own.
    """

    name = "canonical"
    summary = (
        "What presses on the ship from ahead, rolled so that left, right, up and down are one."
    )
    state = Box(
        (
            Field("pressure", "1", 0.0, float(MOST)),
            Field("threat_along", "1", -1.0, 1.0),
            Field("threat_across", "1", -1.0, 1.0),
            Field("threat_offset", "m", 0.0, 12.0),
            Field("course_along", "rad", -4 * HEADING, 4 * HEADING),
            Field("course_across", "rad", 0.0, 4 * HEADING),
        )
    )
    fade_ahead = 20.0
    """Metres ahead over which a rock's weight fades to a third."""
    fade_aside = 6.0
    """Metres of clearance to the side over which it does."""

    def perceive(self, snapshot: Snapshot) -> Percept:
        threats, present = threats_to(snapshot)
        ahead, lateral = threats[:, :, 0], threats[:, :, 1:]
        aside = np.sqrt((lateral**2).sum(axis=2))
        ahead = np.maximum(ahead - ROCK_RADIUS, 0.0) / self.fade_ahead
        clear = np.maximum(aside - REACH, 0.0) / self.fade_aside
        weight = np.where(present, np.exp(-ahead - clear), 0.0)
        push = (weight / np.maximum(aside, 1e-9))[:, :, None] * lateral
        pressure = total(push)
        course = off_course(snapshot)
        strength, along = unit(pressure)
        error, guide = unit(course)
        along = np.where(strength > 1e-6, along, guide)
        along = np.where((strength > 1e-6) | (error > 1e-9), along, (1.0, 0.0))
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        side = (course * across).sum(axis=1, keepdims=True)
        first = (push[:, 0] * across).sum(axis=1, keepdims=True)
        side = np.where(np.abs(side) > 1e-12, side, first)
        across = np.where(side < 0.0, -across, across)
        frame = np.stack([along, across], axis=1)
        offset = weight[:, :1] * np.minimum(aside[:, :1], 12.0)
        states = np.concatenate(
            [strength, turned(frame, push[:, 0]), offset, turned(frame, course)], axis=1
        )
        return Percept(self.state.clip(states), frame)  # rounding can leave -1e-17 for 0

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        return turned(frame, actions)

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        return turned(np.swapaxes(frame, 1, 2), actions)


def off_course(snapshot: Snapshot) -> Array:
    """Yaw and pitch beside the course to hold, rad, shape (worlds, 2).

    The course is straight ahead in the middle of the corridor, and leads back to it, the more
    steeply the nearer the ship comes to its walls.
    """
    width = (snapshot["half"] - MARGIN)[:, None]
    aside = snapshot["position"][:, 1:]
    wander = np.clip((np.abs(aside) / width - 0.4) / 0.6, 0.0, 1.0)
    return np.asarray(snapshot["heading"] + np.sign(aside) * wander * 0.6)


def total(pushes: Array) -> Array:
    """The sum of `pushes` (worlds, N, 2) over N, in that order whatever the batch."""
    return np.asarray(np.add.accumulate(pushes, axis=1)[:, -1])


def unit(vectors: Array) -> tuple[Array, Array]:
    """Lengths (worlds, 1) and directions (worlds, 2) of `vectors` (worlds, 2)."""
    lengths = np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    return lengths, vectors / np.maximum(lengths, 1e-12)


def turned(frames: AnyArray, vectors: Array) -> Array:
    """`vectors` (worlds, 2) multiplied by `frames` (worlds, 2, 2)."""
    return np.asarray((frames * vectors[:, None, :]).sum(axis=2))


def threats_to(snapshot: Snapshot) -> tuple[Array, NDArray[np.bool_]]:
    """The rocks that most endanger the ship, see `worst_threats`."""
    return worst_threats(snapshot, ship_axes(snapshot["heading"]), ROCK_RADIUS, SIGHT)


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

ROCKS: tuple[str, ...] = ("rock_a", "rock_b", "rock_c", "rock_d")
SHIP: tuple[str, ...] = ("hull", "canopy", "trim", "engines")
FLAMES: tuple[str, ...] = ("flame", "core")
Ring = tuple[float, float, float, float, float]
"""Of a hull: x, half width, half height, y and z of its centre."""
Solid = tuple[Array, NDArray[np.int64]]
"""Vertices (V, 3) and faces (F, 3)."""


@lru_cache(maxsize=4)
def tumbled(count: int) -> tuple[Array, Array]:
    """How `count` rocks lie, and how large they are: quaternions (count, 4), scales (count,)."""
    spin = np.random.default_rng(count).uniform(-np.pi, np.pi, (count, 3))
    return quaternions_from_euler(*spin.T), np.full(count, ROCK_RADIUS)


@lru_cache(maxsize=4)
def dust(half: float) -> Body:
    """Motes in the corridor's light, which show how fast the ship flies."""
    rng = np.random.default_rng(7)
    places = rng.uniform((-20.0, -half, -half), (LENGTH + 80.0, half, half), (6000, 3))
    wxyzs = np.tile((1.0, 0.0, 0.0, 0.0), (len(places), 1))
    return Body("dust", "mote", places, wxyzs, rng.uniform(0.02, 0.045, len(places)), fixed=True)


def mote_mesh() -> Mesh:
    """A grain that shines."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=np.float64)
    return Mesh(
        corners, np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]), (168, 190, 235), glow=True
    )


def rock_meshes() -> dict[str, Mesh]:
    """Four chipped boulders of radius 1, within the sphere that collides."""
    colors = ((122, 108, 98), (98, 94, 100), (138, 112, 92), (108, 100, 92))
    meshes: dict[str, Mesh] = {}
    for number, (name, color) in enumerate(zip(ROCKS, colors, strict=True)):
        rng = np.random.default_rng(number)
        ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
        points = np.asarray(ball.vertices, dtype=np.float64) + rng.normal(0, 0.035, (162, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        cuts = rng.normal(size=(20, 3))
        cuts /= np.linalg.norm(cuts, axis=1, keepdims=True)
        depth = rng.uniform(0.8, 0.95, 20)
        facing = np.maximum(points @ cuts.T, 1e-9)
        radius = np.minimum((depth / facing).min(axis=1), 1.0)
        craters = np.exp(-((1.0 - points @ cuts[:4].T) / 0.03)) * 0.09
        radius *= (1.0 - craters.sum(axis=1)) * rng.uniform(0.985, 1.0, len(points))
        meshes[name] = Mesh(
            points * radius[:, None], np.asarray(ball.faces, dtype=np.int64), color, flat=True
        )
    return meshes


def ship_meshes() -> dict[str, Mesh]:
    """A small racer, 3.4 m long: pale hull, glass, orange trim, two engines and their flames."""
    body = [
        (1.9, 0.03, 0.02, 0.0, -0.1),
        (1.0, 0.22, 0.14, 0.0, -0.05),
        (0.1, 0.36, 0.27, 0.0, 0.0),
        (-0.9, 0.40, 0.28, 0.0, 0.02),
        (-1.4, 0.26, 0.18, 0.0, 0.05),
    ]
    glass = [
        (0.95, 0.04, 0.03, 0.0, 0.1),
        (0.45, 0.17, 0.13, 0.0, 0.19),
        (-0.1, 0.2, 0.16, 0.0, 0.24),
        (-0.7, 0.08, 0.05, 0.0, 0.28),
    ]
    pod = [
        (-0.2, 0.1, 0.1, 0.62, -0.1),
        (-0.45, 0.2, 0.18, 0.62, -0.1),
        (-1.3, 0.2, 0.18, 0.62, -0.1),
        (-1.45, 0.15, 0.13, 0.62, -0.1),
    ]
    wing = [(0.5, 0.25, -0.1), (-1.1, 0.25, -0.1), (-1.25, 1.55, -0.3), (-0.75, 1.55, -0.3)]
    tip = [(-0.35, 1.5, -0.31), (-1.5, 1.5, -0.31), (-1.5, 1.72, -0.34), (-0.8, 1.72, -0.34)]
    fin = [(-0.5, 0.3, 0.1), (-1.3, 0.3, 0.1), (-1.65, 0.62, 0.75), (-1.3, 0.62, 0.75)]

    def jet(length: float, wide: float) -> Sequence[Ring]:
        return [
            (-1.44, wide, wide, 0.62, -0.1),
            (-1.44 - 0.3 * length, 0.85 * wide, 0.85 * wide, 0.62, -0.1),
            (-1.44 - length, 0.01, 0.01, 0.62, -0.1),
        ]

    return {
        "hull": joined((214, 220, 230), loft(body, 8), *both(plate(wing, 0.1))),
        "canopy": joined((24, 70, 110), loft(glass, 8)),
        "trim": joined((244, 92, 40), *both(plate(tip, 0.14)), *both(plate(fin, 0.07))),
        "engines": joined((96, 104, 120), *both(loft(pod, 10))),
        "flame": joined((70, 150, 255), *both(loft(jet(1.1, 0.13), 8)), glow=True),
        "core": joined((220, 244, 255), *both(loft(jet(0.5, 0.15), 8)), glow=True),
    }


def loft(rings: Sequence[Ring], sides: int) -> Solid:
    """A closed skin through `rings`, from bow to stern."""
    angle = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    skin = [
        np.stack([np.full(sides, x), y + wide * np.cos(angle), z + high * np.sin(angle)], axis=1)
        for x, wide, high, y, z in rings
    ]
    faces: list[tuple[int, int, int]] = []
    last = (len(rings) - 1) * sides
    for start in range(0, last, sides):
        for side in range(sides):
            a, b = start + side, start + (side + 1) % sides
            faces += [(a, a + sides, b), (b, a + sides, b + sides)]
    for side in range(1, sides - 1):
        faces += [(0, side, side + 1), (last, last + side + 1, last + side)]
    return np.concatenate(skin), np.array(faces)


def plate(outline: Sequence[tuple[float, float, float]], thick: float) -> Solid:
    """A convex plate, `thick` metres from top to bottom."""
    points = np.array(outline)
    hull = trimesh.convex.convex_hull(np.concatenate([points, points + np.array((0, 0, thick))]))
    return np.asarray(hull.vertices), np.asarray(hull.faces)


def both(solid: Solid) -> tuple[Solid, Solid]:
    """`solid` and its mirror image on the ship's other side."""
    return solid, (solid[0] * (1.0, -1.0, 1.0), np.flip(solid[1], axis=1))


def joined(color: tuple[int, int, int], *solids: Solid, glow: bool = False) -> Mesh:
    """One mesh of `solids`."""
    starts = np.cumsum([0, *(len(points) for points, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    points = np.concatenate([points for points, _ in solids]).astype(np.float64)
    return Mesh(points, np.concatenate(faces).astype(np.int64), color, flat=True, glow=glow)


SCENE: type[Scene] = Asteroids
