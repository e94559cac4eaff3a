"""How far feet slide: the travel of what a foot stands on, while it stands."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from evastudio.motion.body import SOLES
from evastudio.motion.figures import JOINTS, Figures, Joints
from evastudio.motion.moment import Activity, Moment
from evastudio.motion.rotations import rotated
from evastudio.world.spaces import Array

CONTACT_M = 0.01
"""A heel or ball this near to the ground stands on it, at size 1."""
RATE_HZ = 240.0
CYCLES = 2
JUMP_M = 0.5
"""Nobody gets so far from one drawn moment to the next."""


def sliding_cm(
    figures: Figures, speed: float, turn_rate: float = 0.0, manner: float = 0.0, size: float = 1.0
) -> Array:
    """Centimetres that each foot slides in a step, left and right, shape (2,).

    A character walks two cycles along its arc. At each moment a foot stands on its lower end,
    heel or ball, if that is on the ground; what this point travels over the ground until the
    next moment is added up, and shared among the foot's steps.
    """
    cadence = float(figures.cadence(speed, turn_rate, size, manner))
    count = round(CYCLES / cadence * RATE_HZ) + 1
    time = np.arange(count) / RATE_HZ
    heading = turn_rate * time
    middle = heading - turn_rate / RATE_HZ / 2
    steps = np.stack([np.cos(middle), np.sin(middle)], axis=1) * speed / RATE_HZ
    steps[0] = 0.0
    moment = Moment(
        np.cumsum(steps, axis=0),
        heading,
        np.full(count, speed),
        cadence * time,
        np.full(count, turn_rate),
        sizes=np.array(size),
        manners=np.array(manner),
    )
    ends = soles(figures.joints(moment), moment.sizes)
    slid, _ = travelled(ends[:-1], ends[1:], np.array([[size]]))
    return np.asarray(slid.sum(axis=0) / CYCLES * 100)


def steps_cm(figures: Figures, moments: Iterable[Moment], sizes: Array) -> Array:
    """Centimetres that feet slid in each step that was ended, of the same people in `moments`.

    A step lasts from the moment a foot touches the ground to the one it leaves it. `sizes` (N,)
    are those of the grown: who is smaller is about to appear, and not counted, as is who is
    somewhere else at once: both happen at the edge of a ground that has none. Nor is who falls.
    """
    found: list[Array] = []
    ends: Array | None = None
    before: Moment | None = None
    for moment in moments:
        now = soles(figures.joints(moment), moment.sizes)
        if ends is None or before is None:
            slid, stood = np.zeros(now.shape[:2]), np.zeros(now.shape[:2], dtype=np.bool_)
        else:
            travel, stands = travelled(ends, now, moment.sizes[:, None])
            slid += travel
            left = stood & ~stands
            found.append(slid[left])
            slid[~stands] = 0.0
            stood = stands
            jumped = np.hypot(*(moment.positions - before.positions)[:, :2].T) > JUMP_M
            jumped |= (moment.sizes < sizes) | (moment.activities > Activity.RUN)
            stood[jumped], slid[jumped] = False, 0.0
        ends, before = now, moment
    return np.concatenate([*found, np.zeros(0)]) * 100


def soles(joints: Joints, sizes: Array) -> Array:
    """Heel and ball of both feet of N people, (N, foot, end, xyz)."""
    ends = []
    for side in ("left", "right"):
        foot = JOINTS.index(f"{side}_foot")
        offset = rotated(joints.wxyzs[foot, :, None], SOLES * sizes[:, None, None])
        ends.append(joints.positions[foot, :, None] + offset)
    return np.stack(ends, axis=1).astype(np.float64)


def travelled(before: Array, after: Array, sizes: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Metres that feet slid between two moments, (N, foot), and which stood at both."""
    lower = before[..., 2].argmin(axis=2)[..., None, None]
    was = np.take_along_axis(before, lower, axis=2)[:, :, 0]
    now = np.take_along_axis(after, lower, axis=2)[:, :, 0]
    stands = (was[..., 2] < CONTACT_M * sizes) & (after[..., 2].min(axis=2) < CONTACT_M * sizes)
    return np.linalg.norm((now - was)[..., :2], axis=2) * stands, stands
