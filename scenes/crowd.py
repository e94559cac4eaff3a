"""People walk about on a square until a boulder falls, and then they run: section 4.2 of the paper.

Until the impact the ground is a grid of cells without an edge (who leaves on one side comes back
on the other) and everybody stands in one cell, turned one of eight ways; twice a second each turns
left or right by an eighth, walks on into the next cell, or stands. After it they run freely, in
any direction. Metres, seconds and radians; x east, y north, z up.

| state of a world | shape     | meaning                                                         |
|------------------|-----------|-----------------------------------------------------------------|
| size             | (N,)      | 1 is 1.75 m tall; fixed                                         |
| looks            | (N,)      | clothes, hair and skin, by number; fixed                        |
| whims            | (N, K)    | random numbers that scripted demonstrators draw on; fixed       |
| position         | (N, 2)    | where everybody is; cells are CELL wide, positions do not wrap  |
| heading          | (N,)      | 0 is east, counter-clockwise; turns add up beyond a full one    |
| speed            | (N,)      | in the last step, m/s                                           |
| phase            | (N,)      | cycles walked so far, for the swing of the legs                 |
| cadence          | (N,)      | cycles a second in the last step                                |
| feet             | (N, 2, 3) | where the left and the right foot stand, or stood last: x, y    |
|                  |           | and heading of its track                                        |
| brisk            | (N,)      | how much of the last ten steps or so one walked, 0 to 1         |
| hit              | (N,)      | 1 for those whom the impact knocked over                        |
| blocked          | (N,)      | steps so far that somebody stood in the way of                  |
| boulder          | (3,)      | where it comes down (x, y), and seconds since it was let go,    |
|                  |           | -1 while there is none                                          |
| lead             | ()        | the character that the animator guides                          |
| steps            | ()        | decisions so far                                                |

An action holds, for every character, how far to turn and how fast to walk; for the lead also
what the animator does besides: let the boulder fall, mark a moment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.motion.footing import at_home
from evastudio.motion.moment import Activity, Footing, Moment
from evastudio.motion.shapes import LOOKS
from evastudio.motion.walkers import Walkers, manners
from evastudio.scenery.boulder import FALL_S, boulder_bodies, boulder_meshes, falling
from evastudio.scenery.fleeing import DOWN_S, KNOCK, Boulder, fleeing, lying, running
from evastudio.scenery.grid import (
    AHEAD,
    EIGHTH,
    clearances,
    eighths,
    granted,
    looked_up,
    occupied,
    wrapped,
)
from evastudio.scenery.mingling import MINUTE_S, mingled
from evastudio.scenery.strolling import (
    CELL,
    LEFT,
    MOVES,
    RIGHT,
    WALK,
    Ahead,
    Own,
    PaperState,
    Paths,
    cells_of,
    strolled,
    symbols,
)
from evastudio.world.bodies import Body, Mesh
from evastudio.world.scene import (
    MARK,
    Control,
    Option,
    Perception,
    Scene,
    Sign,
    Signal,
)
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box, Field

AFTER_S = 12.0
"""A world ends this long after the impact."""
NOWHERE = 1e6
"""Metres to a boulder that has not been let go."""
EMERGE = 1.2
"""Metres over which people grow who come into the ground that is seen."""
WHIMS = 64


class Crowd(Walkers):
    """See the module's docstring."""

    name = "crowd"
    title = "Crowd and boulder"
    version = 2
    dt_s = 0.5
    render_hz = 30.0
    outcomes = ("running", "over")
    successes = frozenset({"over"})
    options = (
        Option("people", "People", 60.0, 1.0, 100_000.0, 1.0, "How many walk about."),
        Option(
            "side",
            "Cells along each side",
            22.0,
            4.0,
            1000.0,
            1.0,
            "The ground is a square of cells.",
        ),
        Option("length", "Seconds", 60.0, 5.0, 3600.0, 5.0, "A scene without a boulder ends then."),
    )
    controls = (
        Control(
            "turn", "turn left or right", ("KeyD", "ArrowRight"), ("KeyA", "ArrowLeft"), 0.0, True
        ),
        Control("walk", "walk on", (), ("KeyW", "ArrowUp"), 0.0, True),
    )
    signals = (
        Signal("drop", "let the boulder fall", "KeyB", "drop", ("drop_x", "drop_y")),
        Signal(MARK, "mark this moment", "KeyM", "mark"),
    )
    signs = (
        Sign("falling", "the boulder is falling"),
        Sign("impact", "the boulder has hit the ground"),
        Sign("hit", "the boulder has knocked one over"),
        Sign("boulder", "the distance to the boulder", "m"),
        Sign("x", "the distance east", "m"),
        Sign("y", "the distance north", "m"),
    )
    action = Box(
        (
            Field("turn", "1", -1.0, 1.0),
            Field("walk", "1", 0.0, 1.0),
            Field("drop", "1", 0.0, 1.0),
            Field("drop_x", "m", -1e6, 1e6),
            Field("drop_y", "m", -1e6, 1e6),
            Field("mark", "1", 0.0, 1.0),
        )
    )

    def __init__(self, **values: float) -> None:
        super().__init__(**values)
        self.people, self.side = int(self.values["people"]), int(self.values["side"])
        self.characters, self.ground = (self.people,), self.side * CELL
        if self.people > self.side**2:
            raise InvalidInputError(
                f"{self.people} people do not fit on {self.side} x {self.side} = {self.side**2} "
                "cells; choose fewer people or a longer side."
            )
        views: tuple[Perception, ...] = (
            Paths(self),
            Ahead(self),
            Own(self),
            PaperState(self),
            Boulder(self),
        )
        self.perceptions = {view.name: view for view in views}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        shape = (worlds, self.people)
        cells = np.stack(
            [rng.choice(self.side**2, self.people, replace=False) for _ in range(worlds)]
        )
        position = np.stack([cells % self.side, cells // self.side], axis=2) * CELL
        fixed = {
            "size": rng.normal(1.0, 0.05, shape).clip(0.88, 1.12),
            "looks": rng.integers(LOOKS, size=shape),
            "whims": rng.random((*shape, WHIMS)),
        }
        heading = rng.integers(8, size=shape) * EIGHTH
        return Snapshot(
            fixed,
            {
                "position": position,
                "heading": heading,
                **self.standing(rng, position, heading),
                "hit": np.zeros(shape, dtype=np.int64),
                "blocked": np.zeros(shape, dtype=np.int64),
                "boulder": np.tile((0.0, 0.0, -1.0), (worlds, 1)),
                "lead": np.zeros(worlds, dtype=np.int64),
                "steps": np.zeros(worlds, dtype=np.int64),
            },
        )

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        """`actions` (worlds, N, 6)."""
        actions = self.action.clip(actions)
        asked = actions[np.arange(snapshot.worlds), snapshot["lead"]]
        boulder = falling(snapshot["boulder"], asked[:, 2] > 0.5, asked[:, 3:5], self.dt_s)
        struck = boulder[:, 2] >= FALL_S
        moving = {} if struck.all() else self._walk(snapshot, actions)
        if struck.any():
            near = self.nearest_image(snapshot)
            for name, wild in running(snapshot, actions, boulder, near, self.dt_s).items():
                here = struck.reshape(-1, *(1,) * (wild.ndim - 1))
                moving[name] = np.where(here, wild, moving.get(name, wild))
        after = snapshot.after(**moving, boulder=boulder, steps=snapshot["steps"] + 1)
        return self.walked(snapshot, after, lying(after))

    def notice(self, snapshot: Snapshot) -> Array:
        ground, since = self.ground, snapshot["boulder"][:, 2:]
        away = snapshot["position"] - snapshot["boulder"][:, None, :2]
        around = away - np.rint(away / ground) * ground
        apart = np.hypot(*np.where(since[:, None] < FALL_S, around, away).transpose(2, 0, 1))
        x, y = np.moveaxis(np.remainder(snapshot["position"] + CELL / 2, ground) - CELL / 2, 2, 0)
        falling, struck = (since >= 0.0) & (since < FALL_S), since >= FALL_S
        told = (falling, struck, snapshot["hit"], np.where(since < 0.0, NOWHERE, apart), x, y)
        return np.stack(np.broadcast_arrays(*told), axis=2).astype(np.float64)

    def _walk(self, snapshot: Snapshot, actions: Array) -> dict[str, AnyArray]:
        """Cell by cell. Of several who claim one cell one goes; who goes changes every step."""
        codes = symbols(actions)
        heading = snapshot["heading"] + np.select(
            [codes == LEFT, codes == RIGHT], [EIGHTH, -EIGHTH]
        )
        facing = eighths(snapshot["heading"])
        asks, goes = self._claims(snapshot, codes, cells_of(snapshot), facing)
        stride = np.where(goes[:, :, None], (CELL * AHEAD)[facing], 0.0)
        return {
            "position": snapshot["position"] + stride,
            "heading": heading,
            "speed": np.where(goes, (CELL * np.hypot(*AHEAD.T))[facing], 0.0) / self.dt_s,
            "hit": snapshot["hit"],
            "blocked": snapshot["blocked"] + (asks & ~goes),
        }

    def instead(self, snapshot: Snapshot, actions: Array) -> Array:
        """Who would be blocked turns to the freer side, the others do as they would.

        To stand would change nothing but the count: a step that is refused is a step stood.
        """
        codes = symbols(actions)
        facing, cells = eighths(snapshot["heading"]), cells_of(snapshot)
        asks, goes = self._claims(snapshot, codes, cells, facing)
        since = snapshot["boulder"][:, 2:]
        calm = (since < 0.0) | (since + self.dt_s < FALL_S)
        left, right = clearances(cells, facing, self.side, (1, -1)).transpose(2, 0, 1)
        by_number = np.where(np.arange(self.people) % 2 == 0, LEFT, RIGHT)
        side = np.select([left > right, right > left], [LEFT, RIGHT], default=by_number)
        turned = actions.copy()
        turned[:, :, :2] = MOVES[side]
        return np.where((asks & ~goes & calm)[:, :, None], turned, actions)

    def _claims(
        self, snapshot: Snapshot, codes: AnyArray, cells: AnyArray, facing: AnyArray
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Who asks to walk on, and who of them gets to, each (worlds, N)."""
        asks = codes == WALK
        target = wrapped(cells + AHEAD[facing], self.side)
        free = asks & ~looked_up(occupied(cells, self.side), target)
        return asks, granted(cells, facing, target, free, snapshot["steps"], self.side)

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        after = snapshot["boulder"][:, 2] - FALL_S
        late = snapshot["steps"] * self.dt_s >= self.values["length"]
        return np.where(np.where(after > -FALL_S, after >= AFTER_S, late), 1, 0)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.clip(snapshot["steps"] * self.dt_s / self.values["length"], 0.0, 1.0)

    def measures(self, moments: Snapshot, actions: Array) -> dict[str, float]:
        """Of walking before the impact, means over people, and the longest of anybody."""
        calm = moments["boulder"][:, 2] < FALL_S
        walk, codes = moments.take(calm), symbols(actions[calm])
        if walk.worlds < 2:
            return {}
        places = wrapped(cells_of(walk), self.side) @ (1, self.side)
        minutes = (walk.worlds - 1) * self.dt_s / MINUTE_S
        return {
            "blocked_per_minute": float(np.ptp(walk["blocked"], axis=0).mean() / minutes),
            **mingled(places, codes, self.dt_s),
        }

    def intention(
        self,
        snapshot: Snapshot,
        *,
        room: float = 2.0,
        wander: float = 0.06,
        rest: float = 0.03,
        haste: float = 0.9,
        drop_s: float = 0.0,
        drop_within_s: float = 0.0,
        **_: float,
    ) -> Array:
        """Walk on, turn to the freer side before somebody comes too near, else as the whim takes.

        room: cells kept free ahead.
        wander: how often one turns though nothing is in the way, share of the decisions.
        rest: how often one stands still, likewise.
        haste: share of the turn away from the boulder that one makes in a decision.
        drop_s: when the lead lets the boulder fall, near by; 0 for never.
        drop_within_s: up to so much later, by chance.
        """
        whim = np.take_along_axis(
            snapshot["whims"], (snapshot["steps"] % WHIMS)[:, None, None], axis=2
        )[:, :, 0]
        chosen = strolled(snapshot, self.side, whim, room, wander, rest)
        actions = np.zeros((*chosen.shape, self.action.size))
        actions[:, :, :2] = MOVES[chosen]
        struck = snapshot["boulder"][:, 2] >= FALL_S
        actions = np.where(
            struck[:, None, None], fleeing(snapshot, self.action.size, haste), actions
        )
        if drop_s:
            lead = (np.arange(snapshot.worlds), snapshot["lead"])
            luck = snapshot["whims"][lead][:, -3:]
            bearing, far = 2 * np.pi * luck[:, 1], KNOCK + 6.0 * luck[:, 2]
            aside = far[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
            begins = np.rint((drop_s + drop_within_s * luck[:, 0]) / self.dt_s)
            now = snapshot["steps"] == begins
            let_go = [now[:, None], snapshot["position"][lead] + aside, np.zeros((len(now), 1))]
            actions[lead] = np.concatenate([actions[lead][:, :2], *let_go], axis=1)
        return actions

    # -- what it looks like --------------------------------------------------------------------

    def meshes(self) -> Mapping[str, Mesh]:
        return {
            **super().meshes(),
            **boulder_meshes(),
        }

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        world = snapshot.take(slice(0, 1))
        lead = self.nearest_image(world)[0, int(world["lead"][0])]
        return [
            *self.square(lead),
            *self.figures.bodies(self.moment(world)),
            *boulder_bodies(world["boulder"][0]),
        ]

    def moment(self, world: Snapshot) -> Moment:
        """What the people of one world do."""
        struck_s = float(world["boulder"][0, 2]) - FALL_S
        position, size, speed = world["position"][0], world["size"][0], world["speed"][0]
        feet = world["feet"][0]
        world = self.striding(world)
        aims = world["aims"][0]
        if struck_s < 0.0:
            shift = self.nearest_image(world)[0] - position
            position = position + shift
            feet, aims = feet.copy(), aims.copy()
            feet[..., :2] += shift[:, None]
            aims[..., :2] += shift[:, None]
        # The ground has no edge: far from the lead people come out of nowhere, growing.
        lead = position[int(world["lead"][0])]
        inside = self.ground / 2 - np.abs(position - lead).max(axis=1)
        grown = np.clip(inside / EMERGE, 0.02, 1.0)
        grown = np.clip(grown + np.clip(struck_s, 0.0, 1.0), 0.0, 1.0)
        down = (world["hit"][0] > 0) & (struck_s >= 0.0) & (struck_s < DOWN_S)
        getting_up_s = self.figures.length_s(Activity.GETTING_UP)
        rises = max(DOWN_S - getting_up_s, DOWN_S / 2)  # a longer movement is made faster
        haste = getting_up_s / (DOWN_S - rises)
        since_s = max((struck_s - rises) * haste if struck_s >= rises else struck_s, 0.0)
        still = np.zeros_like(world["heading"])
        # Who grows does so about the middle, feet included.
        middle = at_home(position, world["heading"][0])
        stood, next_ones = (middle + (one - middle) * grown[:, None, None] for one in (feet, aims))
        return Moment(
            positions=position,
            headings=world["heading"][0],
            speeds=speed * grown,
            phases=world["phase"][0],
            turn_rates=world.moving.get("turn_rate", still)[0],
            activities=np.where(
                down, Activity.FALLEN if struck_s < rises else Activity.GETTING_UP, Activity.WALK
            ),
            since_s=np.array(since_s),
            times_s=float(world["steps"][0]) * self.dt_s + 3.0 * world["whims"][0, :, 0],
            sizes=size * grown,
            looks=world["looks"][0],
            manners=manners(world)[0],
            cadences=world["cadence"][0],
            footing=Footing(stood, next_ones),
        )


SCENE: type[Scene] = Crowd
