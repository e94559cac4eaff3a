"""People cross a square, each to a goal of their own, as in recordings of pedestrians.

Everybody walks freely, in any direction, and decides two and a half times a second how to turn and
how fast to walk, ahead and sideways. Some come and go: worlds that were recorded hold when. Nobody
is kept from walking into others; that is for whoever decides. Metres, seconds and radians; x east,
y north, z up.

| state of a world | shape     | meaning                                                         |
|------------------|-----------|-----------------------------------------------------------------|
| size             | (N,)      | 1 is 1.75 m tall; fixed                                         |
| looks            | (N,)      | clothes, hair and skin, by number; fixed                        |
| pace             | (N,)      | m/s that a scripted demonstrator likes to walk; fixed           |
| goals            | (N, K, 2) | where everybody goes, one goal after the other; fixed           |
| enters           | (N,)      | the step in which they come; fixed                              |
| leaves           | (N,)      | they go at their last goal from this step on; -1: they turn     |
|                  |           | back to the first; fixed                                        |
| ground           | (H, W)    | 1 where one can walk, in cells of CELL; (1, 1) for everywhere;  |
|                  |           | fixed                                                           |
| corner           | (2,)      | where the ground begins; fixed                                  |
| position         | (N, 2)    | where everybody is; of those not there, where they come or went |
| velocity         | (N, 2)    | in the last step, m/s                                           |
| heading          | (N,)      | 0 is east, counter-clockwise; turns add up beyond a full one    |
| phase            | (N,)      | cycles walked so far, for the swing of the legs                 |
| leg              | (N,)      | goals reached so far                                            |
| present          | (N,)      | 1 for those who are there                                       |
| lead             | ()        | the character that the animator guides                          |
| steps            | ()        | decisions so far                                                |

An action holds how far to turn, and the velocity ahead and to the left after the turn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from evastudio.errors import InvalidInputError
from evastudio.motion.figures import figures
from evastudio.motion.moment import Moment
from evastudio.motion.peopled import Peopled
from evastudio.motion.shapes import LOOKS
from evastudio.world.beacon import post_body
from evastudio.world.bodies import Body, Mesh
from evastudio.world.cast import of_lead
from evastudio.world.scene import Control, Option, Percept, Perception, Scene
from evastudio.world.snapshot import AnyArray, Snapshot, stack
from evastudio.world.spaces import Array, Box, Field, Space

REACH = 0.5
"""Metres from a goal at which it counts as reached."""
MOST = 3.0
"""Metres a second, ahead or sideways."""
TURN = 1.6
"""Radians that one can turn in a step."""
WALKS = 0.5
"""Metres a second from which on one faces the way one walks; who goes slower turns less."""
CELL = 0.2
"""Metres from cell to cell of the ground."""
ERRANDS = 4
"""Goals of everybody in a world that was not recorded."""
TOUCH = 0.3
"""Metres between the middles of two people below which they touch."""
STANDS = 0.2
"""Metres a second below which one stands."""
APART = 0.9
"""Metres at least between people when such a world begins."""


class Street(Peopled):
    """See the module's docstring."""

    name = "street"
    title = "People in the street"
    version = 1
    dt_s = 0.4
    render_hz = 30.0
    near_m = 0.2
    outcomes = ("running", "arrived", "late")
    successes = frozenset({"arrived"})
    options = (
        Option("people", "People", 40.0, 1.0, 1000.0, 1.0, "How many walk about."),
        Option("size", "Metres across", 16.0, 4.0, 200.0, 1.0, "The square that they cross."),
        Option("length", "Seconds", 120.0, 5.0, 3600.0, 5.0, "Who has not arrived then is late."),
    )
    controls = (
        Control(
            "turn",
            "turn left or right",
            ("KeyD", "ArrowRight"),
            ("KeyA", "ArrowLeft"),
            0.8,
            reach=0.35,
        ),
        Control("ahead", "walk", ("KeyS", "ArrowDown"), ("KeyW", "ArrowUp"), 1.5, reach=0.5),
    )
    action = Box(
        (
            Field("turn", "rad", -TURN, TURN),
            Field("ahead", "m/s", -MOST, MOST),
            Field("left", "m/s", -MOST, MOST),
        )
    )

    def __init__(self, **values: float) -> None:
        super().__init__(**values)
        self.people = int(self.values["people"])
        self.characters = (self.people,)
        self._along = int(self.values["size"] / APART)
        if self.people > self._along**2:
            raise InvalidInputError(
                f"{self.people} people do not fit on a square of {self.values['size']:g} m, which "
                f"has room for {self._along**2}; choose fewer people or a larger square."
            )
        views = (Goal(), Walls(), Flow())
        self.perceptions: Mapping[str, Perception] = {view.name: view for view in views}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        shape = (worlds, self.people)
        spots = np.stack(
            [rng.choice(self._along**2, self.people, replace=False) for _ in range(worlds)]
        )
        spots = np.stack([spots % self._along, spots // self._along], axis=2)
        position = (spots - (self._along - 1) / 2) * APART
        # Across the middle, and back again.
        turns = np.pi + rng.uniform(-0.9, 0.9, (*shape, ERRANDS))
        bearing = np.arctan2(position[..., 1], position[..., 0])[..., None] + turns.cumsum(axis=2)
        goals = self.values["size"] / 2 * np.stack([np.cos(bearing), np.sin(bearing)], axis=3)
        pace = rng.normal(1.3, 0.2, shape).clip(0.8, 1.8)
        heading = np.arctan2(*(goals[:, :, 0] - position)[..., ::-1].transpose(2, 0, 1))
        way = np.stack([np.cos(heading), np.sin(heading)], axis=2)
        zeros = np.zeros(shape, dtype=np.int64)
        return Snapshot(
            {
                "size": rng.normal(1.0, 0.05, shape).clip(0.88, 1.12),
                "looks": rng.integers(LOOKS, size=shape),
                "pace": pace,
                "goals": goals,
                "enters": zeros,
                "leaves": zeros - 1,
                "ground": np.ones((worlds, 1, 1), dtype=np.uint8),
                "corner": np.zeros((worlds, 2)),
            },
            {
                "position": position,
                "velocity": pace[..., None] * way,
                "heading": heading,
                "phase": rng.random(shape),
                "leg": zeros,
                "present": zeros + 1,
                "lead": np.zeros(worlds, dtype=np.int64),
                "steps": np.zeros(worlds, dtype=np.int64),
            },
        )

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        """`actions` (worlds, N, 3)."""
        actions = self.action.clip(actions)
        here = snapshot["present"] > 0
        steps = snapshot["steps"] + 1
        heading = snapshot["heading"] + np.where(here, actions[..., 0], 0.0)
        velocity = np.where(here[..., None], turned(actions[..., 1:], heading), 0.0)
        position = snapshot["position"] + velocity * self.dt_s
        left = goal_of(snapshot) - position
        leg = snapshot["leg"] + (here & (np.hypot(left[..., 0], left[..., 1]) <= REACH))
        # Who comes moves on as they came: with the velocity that they hold since the beginning.
        comes = ~here & (snapshot["enters"] == steps[:, None])
        goes = (leg >= snapshot["goals"].shape[2]) & (snapshot["leaves"] >= 0)
        goes &= snapshot["leaves"] <= steps[:, None]
        waits = snapshot["enters"] >= steps[:, None]
        cadence = figures().cadence(
            np.hypot(velocity[..., 0], velocity[..., 1]),
            np.where(here, actions[..., 0], 0.0) / self.dt_s,
            snapshot["size"],
        )
        return snapshot.after(
            position=position,
            velocity=np.where(waits[..., None], snapshot["velocity"], velocity),
            heading=heading,
            phase=snapshot["phase"] + np.where(here, self.dt_s * cadence, 0.0),
            leg=leg,
            present=((here & ~goes) | comes).astype(np.int64),
            steps=steps,
        )

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        arrived = of_lead(snapshot, snapshot["leg"]) >= snapshot["goals"].shape[2]
        late = snapshot["steps"] * self.dt_s >= self.values["length"]
        return np.where(arrived, 1, np.where(late, 2, 0))

    def progress(self, snapshot: Snapshot) -> Array:
        reached = of_lead(snapshot, snapshot["leg"]) / snapshot["goals"].shape[2]
        return np.asarray(np.clip(reached, 0.0, 1.0))

    def clearance(self, snapshot: Snapshot) -> Array:
        """From the lead to the nearest other who is there; below zero they touch."""
        lead, worlds = snapshot["lead"], np.arange(snapshot.worlds)
        away = snapshot["position"] - snapshot["position"][worlds, lead][:, None]
        far = np.hypot(away[..., 0], away[..., 1]) - TOUCH
        here = snapshot["present"] > 0
        others = here & here[worlds, lead][:, None]
        others[worlds, lead] = False
        apart = np.where(others, far, np.inf).min(axis=1)
        return np.where(apart <= self.clear_m, apart, np.inf)

    def measures(self, moments: Snapshot, actions: Array) -> dict[str, float]:
        """Of everybody while there: touches, pace, goals reached, and the way made for them."""
        here = moments["present"] > 0
        minutes = here.sum() * self.dt_s / 60.0
        if minutes == 0.0:
            return {}
        velocity = moments["velocity"]
        speed = np.hypot(velocity[..., 0], velocity[..., 1])[here]
        whole = stack([moments, self.step(moments.take(slice(-1, None)), actions[-1:])])
        return {
            "touches_per_minute": float(touches(moments).sum() / minutes),
            "metres_per_second": float(speed.mean()),
            "standing": float((speed < STANDS).mean()),
            "goals_per_minute": float((whole["leg"][-1] - whole["leg"][0]).sum() / minutes),
            "detour": detour(whole),
        }

    def intention(
        self, snapshot: Snapshot, *, room: float = 2.0, wary_s: float = 3.0, **_: float
    ) -> Array:
        """Towards the goal at one's pace, giving way to those whom one would come too near.

        room: how wide a berth to give, in fifths of a metre beyond the width of two people.
        wary_s: seconds that one looks ahead.
        """
        way = goal_of(snapshot) - snapshot["position"]
        distance = np.maximum(np.hypot(way[..., 0], way[..., 1]), 1e-9)[..., None]
        want = way / distance * snapshot["pace"][..., None]
        others = nearest(snapshot, np.arctan2(way[..., 1], way[..., 0]), 6)
        apart = others.apart
        passing = others.velocity - snapshot["velocity"][:, :, None]
        speed = (passing**2).sum(axis=3)
        in_s = np.clip(-(apart * passing).sum(axis=3) / np.maximum(speed, 1e-9), 0.0, wary_s)
        meets = apart + passing * in_s[..., None]
        gap = np.maximum(np.hypot(meets[..., 0], meets[..., 1]), 1e-3)
        # Who would meet head on gives way to the right.
        right = np.stack([want[..., 1], -want[..., 0]], axis=2)[:, :, None]
        aside = -meets + 0.3 * right * np.exp(-gap / 0.2)[..., None]
        aside /= np.maximum(np.hypot(aside[..., 0], aside[..., 1]), 1e-9)[..., None]
        berth = 0.5 + 0.2 * room
        urgency = np.clip(1.0 - gap / berth, 0.0, 1.0) * np.exp(-in_s) * others.seen
        push = 3.0 * (aside * urgency[..., None]).sum(axis=2)
        velocity = snapshot["velocity"] + 0.6 * (want + push - snapshot["velocity"])
        fast = np.maximum(np.hypot(velocity[..., 0], velocity[..., 1]), 1e-9)
        limit = np.minimum(1.3 * snapshot["pace"] / fast, 1.0)
        return moves(snapshot["heading"], velocity * limit[..., None])

    def retraced(self, paths: Array, goals: Array, ground: Array) -> tuple[Snapshot, Array]:
        """See `Scene.retraced`. Who comes later is there from the second time they are seen."""
        moments, people = len(paths) - 1, paths.shape[1]
        there = ~np.isnan(paths[..., 0])
        enters, last = there.argmax(axis=0), moments - there[::-1].argmax(axis=0)
        column = np.arange(people)
        then = np.minimum(enters + 1, last)
        velocity = (paths[then, column] - paths[enters, column]) / self.dt_s
        free, corner = ground_of(ground, paths[:, 0])
        world = self.reset(np.random.default_rng(people), 1)
        moment = Snapshot(
            {
                **world.fixed,
                "goals": goals[None, :, None],
                "enters": enters[None],
                "leaves": last[None],
                "ground": free[None],
                "corner": corner[None],
            },
            {
                **world.moving,
                "position": paths[then, column][None],
                "velocity": velocity[None],
                "heading": np.arctan2(velocity[:, 1], velocity[:, 0])[None],
                "present": (enters == 0).astype(np.int64)[None],
            },
        )
        start, actions = moment, np.zeros((moments - 1, people, self.action.size))
        for step, after in enumerate(paths[2:]):
            want = np.nan_to_num(after - moment["position"][0], nan=0.0) / self.dt_s
            actions[step] = self.action.clip(moves(moment["heading"][0], want))
            moment = self.step(moment, actions[step][None])
        return start, actions

    # -- what it looks like --------------------------------------------------------------------

    def interpolate(self, before: Snapshot, after: Snapshot, fraction: float) -> Snapshot:
        turn_rate = (after["heading"] - before["heading"]) / self.dt_s
        return super().interpolate(before, after, fraction).after(turn_rate=turn_rate)

    def meshes(self) -> Mapping[str, Mesh]:
        corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * (0.5, 0.5, 1.0)
        points = np.concatenate([corners, corners + np.array([0.0, 0.0, 1.0])])
        rims = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
        squares = [*rims, (4, 5, 6, 7)]
        faces = np.array([three for a, b, c, d in squares for three in ((a, b, c), (a, c, d))])
        kerb = Mesh(points, faces, (150, 144, 134), flat=True)
        return {
            **super().meshes(),
            "kerb": kerb,
        }

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        world = snapshot.take(slice(0, 1))
        here = world["present"][0] > 0
        velocity, heading = world["velocity"][0][here], world["heading"][0][here]
        people = Moment(
            positions=world["position"][0][here],
            headings=heading,
            speeds=np.hypot(velocity[:, 0], velocity[:, 1]),
            phases=world["phase"][0][here],
            turn_rates=world.moving.get("turn_rate", np.zeros_like(world["heading"]))[0][here],
            times_s=float(world["steps"][0]) * self.dt_s + 3.0 * world["pace"][0][here],
            sizes=world["size"][0][here],
            looks=world["looks"][0][here],
        )
        lead = world["position"][0, int(world["lead"][0])]
        return [
            *self.square(lead),
            post_body(of_lead(world, goal_of(world))[0]),
            *kerbs(world),
            *self.figures.bodies(people),
        ]


# -- perceptions -------------------------------------------------------------------------------

SEEN = 3
"""People that are perceived."""
FADE = 2.0
"""Metres over which the weight of a person seen falls to 1/e."""
BEHIND = 0.3
"""Who is farther behind than this is not perceived."""
FARTHEST = 5.0
"""Metres; goals beyond are as far as this."""
RAYS = np.radians([0.0, 45.0, -45.0, 90.0, -90.0])
"""Ways from that to the goal along which the free ground is perceived."""
FEELS = np.arange(1, 21) * 0.1
"""Metres at which it is looked for along each."""


MARGIN = 3.0
"""Metres around a recorded lead's way in which the ground is known."""


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


# -- geometry ----------------------------------------------------------------------------------


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


def clearances(snapshot: Snapshot, bearing: Array) -> Array:
    """Metres of free ground along each of RAYS from `bearing` (worlds, N); (worlds, N, rays)."""
    ground = snapshot["ground"]
    worlds, high, wide = ground.shape
    if (high, wide) == (1, 1):
        return np.full((*bearing.shape, len(RAYS)), FEELS[-1])
    angle = bearing[..., None] + RAYS
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=3)[..., None, :] * FEELS[:, None]
    start = snapshot["position"] - snapshot["corner"][:, None]
    cells = np.floor((start[:, :, None, None] + ray) / CELL).astype(np.int64)
    x, y = cells[..., 0], cells[..., 1]
    inside = (x >= 0) & (x < wide) & (y >= 0) & (y < high)
    world = np.arange(worlds)[:, None, None, None]
    free = inside & (ground[world, y.clip(0, high - 1), x.clip(0, wide - 1)] > 0)
    steps = np.where(free.all(axis=3), len(FEELS), free.argmin(axis=3))
    return np.asarray(np.concatenate([[0.0], FEELS])[steps])


def ground_of(points: Array, path: Array) -> tuple[NDArray[np.uint8], Array]:
    """The cells (H, W) at and beside `points` (M, 2) near a `path` (steps, 2), and their corner.

    One free cell, which stands for everywhere, where there are no points.
    """
    low, high = np.nanmin(path, axis=0) - MARGIN, np.nanmax(path, axis=0) + MARGIN
    points = points[((points > low) & (points < high)).all(axis=1)]
    if len(points) == 0:
        return np.ones((1, 1), dtype=np.uint8), low
    wide, tall = np.ceil((high - low) / CELL).astype(np.int64)
    x, y = np.floor((points - low) / CELL).astype(np.int64).T
    cells = np.zeros((tall + 2, wide + 2), dtype=np.uint8)
    for across in range(3):
        for along in range(3):
            cells[y + along, x + across] = 1
    return cells[1:-1, 1:-1], low


def touches(moments: Snapshot) -> NDArray[np.int64]:
    """How often each of those there comes to touch somebody, (N,); `moments` of one world."""
    touching = np.zeros((moments.worlds + 1, moments["present"].shape[1]), dtype=np.bool_)
    for moment, (position, present) in enumerate(
        zip(moments["position"], moments["present"] > 0, strict=True), start=1
    ):
        if present.sum() > 1:
            there = position[present]
            far = KDTree(there).query(there, k=2)[0][:, 1]
            touching[moment, present] = far < TOUCH
    return np.asarray((touching[1:] & ~touching[:-1]).sum(axis=0))


def detour(moments: Snapshot) -> float:
    """Metres walked for each metre straight from goal to goal, mean over those who reached any.

    `moments` of one world from its beginning; NaN where nobody reached a goal.
    """
    position, leg = moments["position"], moments["leg"]
    steps = np.diff(position, axis=0)
    walked = np.concatenate([np.zeros((1, len(leg[0]))), np.hypot(*np.moveaxis(steps, 2, 0))])
    goals = moments["goals"][0]
    turns = np.concatenate([position[0][:, None], goals], axis=1)
    straight = np.hypot(*np.moveaxis(np.diff(turns, axis=1), 2, 0)).cumsum(axis=1)
    shares = []
    for who, reached in enumerate(np.minimum(leg[-1], goals.shape[1])):
        if reached and straight[who, reached - 1] > REACH:
            arrives = int((leg[:, who] >= reached).argmax())
            way = walked[: arrives + 1, who].sum()
            shares.append(way / (straight[who, reached - 1] - REACH))
    return float(np.mean(shares)) if shares else float("nan")


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


def kerbs(world: Snapshot) -> list[Body]:
    """Stones along the edge of the ground, where it has one."""
    ground = world["ground"][0]
    if ground.shape == (1, 1):
        return []
    inner = np.pad(ground, 2)
    beside = inner[:-2, 1:-1] | inner[2:, 1:-1] | inner[1:-1, :-2] | inner[1:-1, 2:]
    y, x = np.nonzero((inner[1:-1, 1:-1] == 0) & (beside > 0))
    cells = np.stack([x - 0.5, y - 0.5], axis=1) * CELL + world["corner"][0]
    places = np.column_stack([cells, np.zeros(len(cells))])
    upright = np.tile((1.0, 0.0, 0.0, 0.0), (len(cells), 1))
    return [Body("kerb", "kerb", places, upright, np.tile((CELL, CELL, 0.12), (len(cells), 1)))]


SCENE: type[Scene] = Street
