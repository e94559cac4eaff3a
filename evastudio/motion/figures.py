"""Figures: a whole crowd's limbs from what its characters do, in one call and without a memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion import keyposes, shapes
from evastudio.motion.body import HIPS, OFFSETS, PARENTS, UPPER
from evastudio.motion.easing import moving, smooth
from evastudio.motion.gait import HURRIED, PHASES, PLAIN, RUNNING, SHY, Gait, gait, stride_at
from evastudio.motion.legs import legs, too_high
from evastudio.motion.moment import Activity, Moment
from evastudio.motion.poses import Poses
from evastudio.motion.rotations import (
    Numbers,
    about,
    product,
    rotated,
)
from evastudio.motion.table import (
    ROOT,
    Floats,
    Table,
    Whole,
    gait_rows,
    resting_rows,
    rows,
)
from evastudio.motion.tracks import on_arc, on_ground, settle, stepped
from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

JOINTS = (
    *UPPER,
    "left_thigh",
    "right_thigh",
    "left_shank",
    "right_shank",
    "left_foot",
    "right_foot",
)
SPEEDS = (0.0, 0.6, 1.2, 1.8, 2.6, 4.0, 5.5)
"""Metres a second at size 1 for which gaits are kept; others are mixed of two.

A gait that was chosen instead stands at each of its speeds, with steps as much longer or shorter.
"""
MANNERS = (SHY, PLAIN, HURRIED)
"""At manner -1, 0 and 1."""
TURN_A_CYCLE = 1.1
"""Radians that two steps on the spot turn."""
SLOWEST_HZ = 0.45
"""Who creeps takes small steps at about this cadence instead of long slow ones."""
GRAVITY = 9.81
LOWERED = 0.15
"""Metres, at most, by which hips sink to reach feet that stand far off."""


@dataclass(frozen=True)
class Joints:
    """Where the joints of N characters are, in the world."""

    positions: Floats
    """Shape (15, N, 3), in the order of `JOINTS`."""
    wxyzs: Floats
    """Shape (15, N, 4)."""


@dataclass(frozen=True)
class _Timed:
    """A movement that runs once."""

    start: int
    """Its first row."""
    last: int
    """Number of rows after that."""
    fade_in_s: float
    """Seconds over which it takes over from walking or standing."""
    fade_out_s: float
    """Seconds over which it hands back at its end; 0 for one that stays."""


class Figures:
    """Bodies that walk, stand, turn, run, stagger, fall and get up.

    Making one takes some 50 ms; afterwards it only reads.
    """

    def __init__(
        self,
        gaits: Mapping[Activity, Gait] | None = None,
        movements: Mapping[Activity, Poses] | None = None,
    ) -> None:
        """Figures that move as shipped, but for the `gaits` of walking and running and the
        `movements` of other activities that are given.

        Raises InvalidInputError for an activity that has no such thing.
        """
        table = self._table = Table()
        self._speeds = np.array(SPEEDS)
        self._walks = np.zeros((len(MANNERS), len(SPEEDS)), dtype=np.int64)
        self._strides = np.zeros(self._walks.shape)
        starts = {code: table.add(gait_rows(one)) for code, one in (gaits or {}).items()}
        for row, manner in enumerate(MANNERS):
            for column, speed in enumerate(SPEEDS):
                self._strides[row, column] = stride_at(speed, manner)
                code = Activity.RUN if speed >= RUNNING else Activity.WALK
                if gaits and code in gaits:
                    one = gaits[code]
                    self._walks[row, column] = starts[code]
                    self._strides[row, column] *= one.stride_m / stride_at(one.speed)
                else:
                    self._walks[row, column] = table.add(gait_rows(gait(speed, manner)))
        chosen = dict(movements or {})
        resting = chosen.pop(Activity.STAND) if Activity.STAND in chosen else None
        stands = [
            resting_rows(keyposes.stand(manner) if resting is None else resting)
            for manner in MANNERS
        ]
        self._stands = np.array([table.add(stand) for stand in stands])
        self._stand_rows = len(stands[0]) - 1
        timed: dict[Activity, _Timed] = {}
        for code, shipped, fade_in_s, fade_out_s in ONCE:
            poses = chosen.pop(code) if code in chosen else shipped()
            timed[code] = _Timed(table.add(rows(poses)), len(poses) - 1, fade_in_s, fade_out_s)
        self._timed = timed
        wrong = [code.name for code in chosen] + [code.name for code in starts if code not in GAITS]
        if wrong:
            raise InvalidInputError(f"No clip can be chosen for {', '.join(wrong)}.")

    def length_s(self, activity: Activity) -> float:
        """How long a stagger, the way down of a fall, or getting up takes."""
        return self._timed[activity].last / keyposes.RATE_HZ

    def cadence(
        self,
        speeds: Numbers | float,
        turn_rates: Numbers | float = 0.0,
        sizes: Numbers | float = 1.0,
        manners: Numbers | float = 0.0,
    ) -> Array:
        """Cycles a second at these speeds: what a scene adds up to the phases of its characters."""
        speeds = np.abs(speeds) / sizes
        ahead = speeds / self._mixed_strides(speeds, np.asarray(manners))
        around = np.asarray(turn_rates) / TURN_A_CYCLE
        slow = SLOWEST_HZ * moving(speeds, turn_rates) * (1 - smooth(speeds / 1.2))
        return np.asarray(np.sqrt(ahead**2 + around**2 + slow**2))

    def joints(self, moment: Moment) -> Joints:
        """Where all joints are."""
        sizes = moment.sizes.astype(np.float32)
        speeds = (np.abs(moment.speeds) / moment.sizes).astype(np.float32)
        turns = moment.turn_rates.astype(np.float32)
        cadence = np.maximum(
            self.cadence(moment.speeds, turns, moment.sizes, moment.manners), 1e-3
        ).astype(np.float32)
        walking = moving(speeds, turns)
        if moment.cadences is not None:
            walking = smooth(moment.cadences.astype(np.float32) / SLOWEST_HZ)
        indices, weights = self._mix(moment, speeds, walking)
        table = self._table.mixed(indices, weights)
        held = None
        if moment.footing is None:
            tracks = on_arc(table, speeds / cadence, turns / cadence)
        else:
            upright = weights[:, :12].sum(axis=1)
            tracks, held = on_ground(table, moment, walking * upright, upright)
            settle(table)
        upper, ankles, feet, hinges = stepped(table, *tracks)
        root = np.moveaxis(table[ROOT], 0, -1)
        lean = -0.6 * np.arctan(speeds * turns / GRAVITY)
        root[:, 1] -= lean * root[:, 2]
        count = len(sizes)
        places = np.empty((3, len(JOINTS), count), dtype=np.float32)
        wxyzs = np.empty((4, len(JOINTS), count), dtype=np.float32)
        at, turn = np.moveaxis(places, 0, -1), np.moveaxis(wxyzs, 0, -1)
        at[0], turn[0] = root, product(about(0, lean), upper[0])
        glance = about(2, 0.35 * np.clip(turns, -1.2, 1.2))
        upper[2] = product(glance, upper[2])
        for these in LEVELS:
            above = slice(PARENTS[these.start], PARENTS[these.stop - 1] + 1)
            over = turn[above]
            offsets = OFFSETS[these, None].astype(np.float32)
            at[these] = at[above] + rotated(over, offsets)
            turn[these] = product(over, upper[these])
        sockets = at[0] + rotated(turn[0], HIPS[:, None].astype(np.float32))
        if held is not None:
            lower = held * np.clip(too_high(sockets, ankles), 0.0, LOWERED)
            at[:9, :, 2] -= lower.max(axis=0)
            sockets[..., 2] -= lower.max(axis=0)
        knees, reached, thighs, shanks = legs(sockets, ankles, hinges)
        at[9:11], at[11:13], at[13:15] = sockets, knees, reached
        turn[9:11], turn[11:13], turn[13:15] = thighs, shanks, feet
        self._placed(places, wxyzs, moment, sizes)
        return Joints(np.moveaxis(places, 0, -1), np.moveaxis(wxyzs, 0, -1))

    def meshes(self) -> Mapping[str, Mesh]:
        """The meshes that `bodies` names."""
        return {f"figure_{name}": mesh for name, mesh in shapes.meshes().items()}

    def bodies(self, moment: Moment) -> list[Body]:
        """What to draw: one body for each mesh, with all limbs that it is the shape of."""
        joints = self.joints(moment)
        looks = moment.looks % shapes.LOOKS
        sizes, broad = moment.sizes.astype(np.float32), shapes.builds()[looks]
        wardrobe = shapes.wardrobe()
        drawn = []
        everybody = slice(None)
        limbs: dict[str, list[tuple[shapes.Limb, slice | Whole]]] = {}
        for limb in shapes.LIMBS:
            limbs.setdefault(limb.mesh, []).append((limb, everybody))
        for number, cut in enumerate(shapes.HAIRCUTS):
            wearing = np.flatnonzero(looks % len(shapes.HAIRCUTS) == number)
            limbs[cut] = [(shapes.Limb("head", cut, color="hair"), wearing)]
        for mesh, parts in limbs.items():
            numbers = [(JOINTS.index(limb.joint), limb, who) for limb, who in parts]
            drawn.append(
                Body(
                    f"figure_{mesh}",
                    f"figure_{mesh}",
                    np.concatenate([joints.positions[joint, who] for joint, _, who in numbers]),
                    np.concatenate([joints.wxyzs[joint, who] for joint, _, who in numbers]),
                    np.concatenate(
                        [_scales(limb, sizes[who], broad[who]) for _, limb, who in numbers]
                    ),
                    colors=np.concatenate(
                        [wardrobe[limb.color][looks[who]] for _, limb, who in numbers]
                    ),
                )
            )
        return [*drawn, _shadows(joints, moment)]

    def _mixed_strides(self, speeds: Numbers, manners: Numbers) -> Array:
        """Metres a cycle at size 1."""
        (low, share), (style, part) = self._bracket(speeds), _manner(manners)
        strides = self._strides
        slow = strides[style, low] * (1 - share) + strides[style, low + 1] * share
        fast = strides[style + 1, low] * (1 - share) + strides[style + 1, low + 1] * share
        return np.asarray(slow * (1 - part) + fast * part)

    def _bracket(self, speeds: Numbers) -> tuple[Whole, Numbers]:
        """Index of the gait below each speed, and how far towards the next it lies."""
        low = np.clip(np.searchsorted(self._speeds, speeds, "right") - 1, 0, len(self._speeds) - 2)
        gap = self._speeds[low + 1] - self._speeds[low]
        return low, np.clip((speeds - self._speeds[low]) / gap, 0.0, 1.0)

    def _mix(self, moment: Moment, speeds: Floats, walking: Floats) -> tuple[Whole, Floats]:
        """Rows of the table and their weights, each (N, 14); the last two of what runs once."""
        walking, standing = walking.copy(), 1 - walking
        count = len(speeds)
        indices = np.zeros((14, count), dtype=np.int32)
        weights = np.zeros((14, count), dtype=np.float32)
        for code, once in self._timed.items():
            doing = np.flatnonzero(moment.activities == code)
            if len(doing) == 0:
                continue
            since = moment.since_s[doing]
            taken = smooth(since / once.fade_in_s) if once.fade_in_s else np.ones(len(doing))
            if once.fade_out_s:
                taken = taken * smooth((once.last / keyposes.RATE_HZ - since) / once.fade_out_s)
            place = np.clip(since * keyposes.RATE_HZ, 0, once.last)
            row = np.minimum(place.astype(np.int64), once.last - 1)
            indices[12, doing], indices[13, doing] = once.start + row, once.start + row + 1
            weights[12, doing] = taken * (1 - place + row)
            weights[13, doing] = taken * (place - row)
            walking[doing] *= 1 - taken
            standing[doing] *= 1 - taken
        (low, share), (style, part) = self._bracket(speeds), _manner(moment.manners)
        cycle = np.mod(moment.phases, 1.0) * PHASES
        row = np.minimum(cycle.astype(np.int64), PHASES - 1)
        late = cycle - row
        place = (
            np.mod(moment.times_s * (keyposes.RATE_HZ / self._stand_rows), 1.0) * self._stand_rows
        )
        rest = np.minimum(place.astype(np.int64), self._stand_rows - 1)
        term = 0
        for way, manner in ((style, 1 - part), (style + 1, part)):
            for kind, weight in ((low, 1 - share), (low + 1, share)):
                first = self._walks[way, kind] + row
                for extra, near in ((0, 1 - late), (1, late)):
                    indices[term], weights[term] = first + extra, walking * manner * weight * near
                    term += 1
            for extra, near in ((0, 1 - place + rest), (1, place - rest)):
                indices[term] = self._stands[way] + rest + extra
                weights[term] = standing * manner * near
                term += 1
        return indices.T, weights.T

    def _placed(self, places: Floats, wxyzs: Floats, moment: Moment, sizes: Floats) -> None:
        """Move joints from each character's own frame to the world's, in place."""
        c, s = (
            np.cos(moment.headings).astype(np.float32),
            np.sin(moment.headings).astype(np.float32),
        )
        places *= sizes
        x, y = places[0].copy(), places[1].copy()
        ground = moment.positions.T
        places[0] = c * x - s * y + ground[0].astype(np.float32)
        places[1] = s * x + c * y + ground[1].astype(np.float32)
        if len(ground) == 3:
            places[2] += ground[2].astype(np.float32)
        half = moment.headings / 2
        c, s = np.cos(half).astype(np.float32), np.sin(half).astype(np.float32)
        w, x, y, z = wxyzs.copy()
        wxyzs[0], wxyzs[1], wxyzs[2], wxyzs[3] = (
            c * w - s * z,
            c * x - s * y,
            c * y + s * x,
            c * z + s * w,
        )


LEVELS = (slice(1, 2), slice(2, 3), slice(3, 5), slice(5, 7), slice(7, 9))
"""Joints of `UPPER` that can be turned together, after those they hang on."""
ONCE = (
    (Activity.STAGGER, keyposes.stagger, 0.12, 0.35),
    (Activity.FALLEN, keyposes.fall, 0.15, 0.0),
    (Activity.GETTING_UP, keyposes.get_up, 0.0, 0.35),
)
"""Movements that run once, with the seconds over which they take over and hand back."""
GAITS = (Activity.WALK, Activity.RUN)
"""Activities that are walked in cycles."""


def _manner(manners: Numbers) -> tuple[Whole, Numbers]:
    place = np.clip(manners, -1.0, 1.0) + 1
    low = np.minimum(place.astype(np.int64), len(MANNERS) - 2)
    return low, place - low


def _shadows(joints: Joints, moment: Moment) -> Body:
    """A dark spot under each: nothing else tells that feet are on the ground."""
    hips, head = joints.positions[0], joints.positions[2]
    lies = (head - hips)[:, :2]
    along = np.linalg.norm(lies, axis=1)
    sizes = moment.sizes.astype(np.float32)
    places = hips.copy()
    places[:, :2] += lies / 2 * np.minimum(along / (0.4 * sizes), 1.0)[:, None]
    places[:, 2] = 0.012
    if moment.positions.shape[1] == 3:
        places[:, 2] += moment.positions[:, 2]
    half = np.arctan2(lies[:, 1], lies[:, 0]) / 2
    wxyzs = np.zeros((len(hips), 4), dtype=np.float32)
    wxyzs[:, 0], wxyzs[:, 3] = np.cos(half), np.sin(half)
    scales = np.stack([0.26 * sizes + 0.9 * along, 0.26 * sizes, sizes], axis=1)
    return Body("figure_shadow", "figure_shadow", places, wxyzs, scales)


def _scales(limb: shapes.Limb, sizes: Floats, broad: Floats) -> Floats:
    scales = sizes[:, None] * np.array(limb.size, dtype=np.float32)
    if limb.mesh in ("limb", "torso", "hips"):
        scales[:, :2] *= broad[:, None]
    return scales


@lru_cache(maxsize=1)
def figures() -> Figures:
    """The bodies as shipped, made once for all scenes that people walk in."""
    return Figures()
