"""How far feet slide: the travel of what a foot stands on, while it stands."""

from __future__ import annotations

import numpy as np

from evastudio.motion.body import SOLES
from evastudio.motion.figures import JOINTS, Figures
from evastudio.motion.moment import Moment
from evastudio.motion.rotations import rotated
from evastudio.world.spaces import Array

CONTACT_M = 0.01
"""A heel or ball this near to the ground stands on it, at size 1."""
RATE_HZ = 240.0
CYCLES = 2


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
    joints = figures.joints(moment)
    soles = []
    for side in ("left", "right"):
        foot = JOINTS.index(f"{side}_foot")
        ends = rotated(joints.wxyzs[foot, :, None], SOLES * size)
        soles.append(joints.positions[foot, :, None] + ends)
    ends = np.stack(soles, axis=1).astype(np.float64)  # (time, foot, end, xyz)
    lower = ends[..., 2].argmin(axis=2)[..., None, None]
    height = np.take_along_axis(ends[..., 2:], lower, axis=2)[:, :, 0, 0]
    before = np.take_along_axis(ends[:-1], lower[:-1], axis=2)[:, :, 0, :2]
    after = np.take_along_axis(ends[1:], lower[:-1], axis=2)[:, :, 0, :2]
    stands = (height[:-1] < CONTACT_M * size) & (height[1:] < CONTACT_M * size)
    travel = np.linalg.norm(after - before, axis=2) * stands
    return np.asarray(travel.sum(axis=0) / CYCLES * 100)
