"""Movements that are no gait: standing, staggering, falling, lying, getting up. Drawn by hand.

Each is a row of poses in time; between them runs a smooth curve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from evastudio.motion.body import ANKLE, HALF_HIPS, SHANK, THIGH
from evastudio.motion.gait import PLAIN, Manner
from evastudio.motion.poses import Poses
from evastudio.motion.rotations import about, product
from evastudio.world.spaces import Array

RATE_HZ = 24.0
STAND_S = 6.0
"""Seconds after which standing repeats: two breaths and one shift of weight."""
TALL = THIGH + SHANK + ANKLE - 0.02


@dataclass(frozen=True)
class Pose:
    """One drawn pose. Angles in rad: pitch forward, roll to the left side up, yaw to the left."""

    root: tuple[float, float, float] = (0.0, 0.0, TALL)
    hips: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Pitch, roll, yaw."""
    chest: tuple[float, float, float] = (0.0, 0.0, 0.0)
    head: tuple[float, float, float] = (0.0, 0.0, 0.0)
    left_arm: tuple[float, float, float] = (0.0, 0.12, 0.25)
    """Forward, outward, bend of the elbow."""
    right_arm: tuple[float, float, float] = (0.0, 0.12, 0.25)
    left_foot: tuple[float, float, float, float] = (0.0, 0.09, ANKLE, 0.0)
    """Ankle ahead, left, up in metres, and pitch, toes down."""
    right_foot: tuple[float, float, float, float] = (0.0, -0.09, ANKLE, 0.0)

    def numbers(self) -> Array:
        parts = (self.root, self.hips, self.chest, self.head, self.left_arm, self.right_arm)
        return np.concatenate([*parts, self.left_foot, self.right_foot])


def movement(times_s: Array, poses: list[Pose]) -> Poses:
    """Poses at about `RATE_HZ` that pass through `poses` at `times_s`, without overshooting."""
    curve = PchipInterpolator(times_s, np.stack([pose.numbers() for pose in poses]))
    moments = round(times_s[-1] * RATE_HZ) + 1
    return drawn(curve(np.linspace(0.0, times_s[-1], moments)))


def drawn(numbers: Array) -> Poses:
    """The poses of rows of `Pose.numbers()`, shape (F, 26)."""
    trunk = [_turned(numbers[:, start : start + 3]) for start in (3, 6, 9)]
    arms, fore, hands = [], [], []
    for side, start in ((1, 12), (-1, 15)):
        ahead, out, bend = numbers[:, start : start + 3].T
        arms.append(product(about(1, -ahead), about(0, side * out)))
        fore.append(product(about(2, np.full_like(bend, -0.25 * side)), about(1, -bend)))
        hands.append(about(1, -0.2 * bend))
    ankles = np.stack([numbers[:, 18:21], numbers[:, 22:25]], axis=1)
    pitch = numbers[:, [21, 25]]
    feet = product(about(2, np.array([0.15, -0.15])), about(1, pitch))
    splay = np.array([[-0.15, 1.0, 0.0], [0.15, 1.0, 0.0]])
    hinges = np.broadcast_to(splay, (len(numbers), 2, 3))
    upper = np.stack([*trunk, *arms, *fore, *hands], axis=1)
    return Poses(numbers[:, :3].copy(), upper, ankles, feet, np.array(hinges))


def _turned(angles: Array) -> Array:
    pitch, roll, yaw = angles.T
    return product(about(2, yaw), product(about(1, pitch), about(0, roll)))


def stand(manner: Manner = PLAIN) -> Poses:
    """Breathing and shifting weight for `STAND_S`, after which it begins again."""
    time = np.arange(round(STAND_S * RATE_HZ)) / (STAND_S * RATE_HZ)
    rest = Pose(
        root=(0.0, 0.0, TALL - 0.012),
        chest=(0.6 * manner.lean, 0.0, 0.0),
        head=(manner.bow - 0.4 * manner.lean, 0.0, 0.0),
        left_arm=(0.02, manner.spread, manner.elbow),
        right_arm=(0.02, manner.spread, manner.elbow),
        left_foot=(0.01, HALF_HIPS * (0.3 + manner.width), ANKLE, 0.0),
        right_foot=(-0.01, -HALF_HIPS * (0.3 + manner.width), ANKLE, 0.0),
    )
    numbers = np.tile(rest.numbers(), (len(time), 1))
    shift, breath = np.sin(2 * np.pi * time), np.sin(4 * np.pi * time)
    numbers[:, 1] += 0.028 * shift
    numbers[:, 2] -= 0.006 * shift**2
    numbers[:, 4] += 0.035 * shift
    numbers[:, 7] -= 0.05 * shift
    numbers[:, 6] -= 0.018 * breath
    numbers[:, 9] += 0.02 * breath
    numbers[:, 11] += 0.22 * np.sin(2 * np.pi * time + 1.0) * np.abs(shift)
    numbers[:, 13] += 0.02 * breath
    numbers[:, 16] += 0.02 * breath
    return drawn(numbers)


LYING = Pose(
    root=(-0.55, 0.0, 0.13),
    hips=(-1.52, 0.0, 0.0),
    chest=(0.05, 0.0, 0.0),
    head=(0.15, 0.0, 0.3),
    left_arm=(0.0, 1.0, 0.3),
    right_arm=(-0.05, 0.7, 0.4),
    left_foot=(0.20, 0.2, 0.09, -1.1),
    right_foot=(-0.02, -0.13, ANKLE, -0.1),
)
STANDING = Pose(root=(0.0, 0.0, TALL - 0.012))


def stagger() -> Poses:
    """Hit, thrown off balance, two steps to catch it, upright again."""
    hit = Pose(
        root=(-0.10, 0.04, 0.86),
        hips=(-0.22, 0.08, 0.25),
        chest=(-0.3, 0.12, 0.2),
        head=(0.35, 0.0, -0.2),
        left_arm=(0.9, 0.9, 0.5),
        right_arm=(0.5, 1.2, 0.4),
        left_foot=(0.02, 0.1, ANKLE, -0.2),
        right_foot=(-0.12, -0.12, 0.13, 0.3),
    )
    back = Pose(
        root=(-0.2, -0.06, 0.80),
        hips=(0.1, -0.08, -0.1),
        chest=(0.35, -0.12, -0.25),
        head=(-0.2, 0.0, 0.2),
        left_arm=(0.3, 1.2, 0.6),
        right_arm=(-0.5, 1.0, 0.4),
        left_foot=(0.02, 0.1, ANKLE, 0.0),
        right_foot=(-0.34, -0.15, ANKLE, 0.15),
    )
    catch = Pose(
        root=(-0.06, 0.05, 0.84),
        hips=(0.12, 0.03, 0.1),
        chest=(0.2, 0.06, 0.1),
        left_arm=(0.2, 0.7, 0.7),
        right_arm=(0.4, 0.8, 0.6),
        left_foot=(0.0, 0.12, ANKLE, 0.0),
        right_foot=(-0.2, -0.13, 0.13, 0.35),
    )
    times = np.array([0.0, 0.22, 0.55, 0.9, 1.3])
    return movement(times, [STANDING, hit, back, catch, STANDING])


def fall() -> Poses:
    """Knocked backwards: arms up, seated, on the back; the last pose lies still."""
    hit = Pose(
        root=(-0.18, 0.0, 0.80),
        hips=(-0.45, 0.05, 0.1),
        chest=(-0.05, 0.1, 0.15),
        head=(0.5, 0.0, 0.0),
        left_arm=(1.5, 0.7, 0.4),
        right_arm=(1.2, 0.9, 0.6),
        left_foot=(0.10, 0.1, 0.12, -0.5),
        right_foot=(-0.02, -0.11, ANKLE, 0.0),
    )
    seated = Pose(
        root=(-0.48, 0.0, 0.24),
        hips=(-0.85, 0.0, 0.0),
        chest=(0.35, 0.05, 0.1),
        head=(0.45, 0.0, 0.0),
        left_arm=(-0.3, 0.9, 0.5),
        right_arm=(-0.5, 0.8, 0.5),
        left_foot=(0.22, 0.17, 0.22, -0.8),
        right_foot=(0.0, -0.12, ANKLE, -0.1),
    )
    bounced = replace(LYING, root=(-0.56, 0.0, 0.15), head=(-0.1, 0.0, 0.2), hips=(-1.5, 0.0, 0.0))
    times = np.array([0.0, 0.25, 0.62, 0.9, 1.15])
    return movement(times, [STANDING, hit, seated, bounced, LYING])


def get_up() -> Poses:
    """From lying on the back to sitting, to a crouch, to the feet."""
    sitting = Pose(
        root=(-0.46, 0.0, 0.15),
        hips=(-0.35, 0.0, -0.1),
        chest=(0.55, 0.0, -0.2),
        head=(0.0, 0.0, 0.0),
        left_arm=(0.6, 0.3, 0.6),
        right_arm=(-0.9, 0.4, 0.1),
        left_foot=(0.06, 0.14, ANKLE, 0.0),
        right_foot=(-0.02, -0.13, ANKLE, 0.0),
    )
    rocking = replace(
        sitting,
        root=(-0.24, 0.0, 0.30),
        hips=(0.55, 0.0, -0.1),
        chest=(0.5, 0.0, -0.1),
        left_arm=(1.0, 0.3, 0.5),
        right_arm=(0.2, 0.4, 0.3),
        left_foot=(0.03, 0.12, ANKLE, 0.0),
    )
    crouch = replace(
        rocking,
        root=(-0.04, 0.0, 0.55),
        hips=(0.75, 0.0, 0.0),
        chest=(0.35, 0.0, 0.0),
        head=(-0.5, 0.0, 0.0),
        left_arm=(0.7, 0.2, 0.5),
        right_arm=(0.6, 0.2, 0.5),
    )
    times = np.array([0.0, 0.6, 1.05, 1.4, 2.1])
    return movement(times, [LYING, sitting, rocking, crouch, STANDING])
