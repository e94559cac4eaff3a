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

from evastudio.errors import InvalidInputError
from evastudio.motion.figures import figures
from evastudio.motion.moment import Moment
from evastudio.motion.peopled import Peopled
from evastudio.motion.shapes import LOOKS
from evastudio.scenery.beacon import post_body
from evastudio.scenery.free_ground import ground_of, kerb_bodies, kerb_mesh
from evastudio.scenery.passing import TOUCH, detour, touches
from evastudio.scenery.pedestrians import (
    MOST,
    TURN,
    Flow,
    Goal,
    Walls,
    goal_of,
    moves,
    nearest,
    turned,
)
from evastudio.world.bodies import Body, Mesh
from evastudio.world.cast import of_lead
from evastudio.world.scene import Control, Option, Perception, Scene
from evastudio.world.snapshot import Snapshot, stack
from evastudio.world.spaces import Array, Box, Field

REACH = 0.5
"""Metres from a goal at which it counts as reached."""
ERRANDS = 4
"""Goals of everybody in a world that was not recorded."""
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
            "detour": detour(whole, REACH),
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
        return {**super().meshes(), "kerb": kerb_mesh()}

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
            *kerb_bodies(world),
            *self.figures.bodies(people),
        ]


SCENE: type[Scene] = Street
