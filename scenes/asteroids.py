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

import numpy as np
from numpy.typing import NDArray

from evastudio.scenery.bounds import bar_mesh, bounds
from evastudio.scenery.rubble import dust, mote_mesh, rock_bodies, rock_meshes
from evastudio.scenery.spaceship import ship_bodies, ship_meshes
from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.course import Course
from evastudio.world.geometry import columns, directions, quaternions_from_euler
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
        aside, above = np.abs(position[:, 1]), np.abs(position[:, 2])
        left = np.maximum(aside, above) > self.values["half_width"]
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
        aside = lengths(lateral)
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
        return {**rock_meshes(), **ship_meshes(), "mote": mote_mesh(), "bar": bar_mesh()}

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        theta, phi = snapshot["heading"][0]
        ship = snapshot["position"][:1]
        bank = -snapshot["turn"][0, 0] / TURN * np.radians(35.0)
        pose = quaternions_from_euler(np.array([bank]), np.array([-phi]), np.array([theta]))
        return [
            *rock_bodies(snapshot["rocks"][0], ROCK_RADIUS),
            dust(LENGTH, self.values["half_width"]),
            bounds(LENGTH, self.values["half_width"]),
            *ship_bodies(ship, pose),
        ]

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
        aside = lengths(lateral)
        ahead = np.maximum(ahead - ROCK_RADIUS, 0.0) / self.fade_ahead
        clear = np.maximum(aside - REACH, 0.0) / self.fade_aside
        weight = np.where(present, np.exp(-ahead - clear), 0.0)
        push = (weight / np.maximum(aside, 1e-9))[:, :, None] * lateral
        pressure = total(push)
        course = off_course(snapshot)
        strength, along = unit(pressure)
        error, guide = unit(course)
        pressed = strength > 1e-6
        along = np.where(pressed, along, guide)
        along = np.where(pressed | (error > 1e-9), along, (1.0, 0.0))
        across = columns(-along[:, 1], along[:, 0])
        side = dot(course, across)
        side = np.where(np.abs(side) > 1e-12, side, dot(push[:, 0], across))[:, None]
        across = np.where(side < 0.0, -across, across)
        frame = np.empty((len(along), 2, 2))
        frame[:, 0], frame[:, 1] = along, across
        states = np.empty((len(along), self.state.size))
        states[:, :1] = strength
        states[:, 1:3] = turned(frame, push[:, 0])
        states[:, 3] = weight[:, 0] * np.minimum(aside[:, 0], 12.0)
        states[:, 4:] = turned(frame, course)
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


def dot(one: Array, other: Array) -> Array:
    """The products (...) of vectors (..., 2), summed without the cost of a reduction."""
    return np.asarray(one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1])


def lengths(vectors: Array) -> Array:
    """Of `vectors` (..., 2), shape (...)."""
    return np.asarray(np.sqrt(dot(vectors, vectors)))


def unit(vectors: Array) -> tuple[Array, Array]:
    """Lengths (worlds, 1) and directions (worlds, 2) of `vectors` (worlds, 2)."""
    long = lengths(vectors)[:, None]
    return long, vectors / np.maximum(long, 1e-12)


def turned(frames: AnyArray, vectors: Array) -> Array:
    """`vectors` (worlds, 2) multiplied by `frames` (worlds, 2, 2)."""
    return dot(frames, vectors[:, None, :])


def threats_to(snapshot: Snapshot) -> tuple[Array, NDArray[np.bool_]]:
    """The rocks that most endanger the ship, see `worst_threats`."""
    return worst_threats(snapshot, ship_axes(snapshot["heading"]), ROCK_RADIUS, SIGHT)


def ship_axes(heading: Array) -> tuple[Array, Array, Array]:
    """Forward, left and up of ships with `heading` (worlds, 2), each of shape (worlds, 3)."""
    cos_t, sin_t = np.cos(heading[:, 0]), np.sin(heading[:, 0])
    cos_p, sin_p = np.cos(heading[:, 1]), np.sin(heading[:, 1])
    zero = np.zeros(len(heading))
    return (
        columns(cos_p * cos_t, cos_p * sin_t, sin_p),
        columns(-sin_t, cos_t, zero),
        columns(-sin_p * cos_t, -sin_p * sin_t, cos_p),
    )


SCENE: type[Scene] = Asteroids
