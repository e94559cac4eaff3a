"""The shipped walk and run, made from a few rules: no recording behind them.

A cycle begins when the left foot touches down; the right one follows half a cycle later.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from evastudio.motion.body import ANKLE, HALF_HIPS, HIPS, SHANK, SOLES, THIGH
from evastudio.motion.poses import Poses
from evastudio.motion.rotations import about, product, rotated
from evastudio.world.spaces import Array

PHASES = 64
"""Moments of a cycle that are kept; between them is interpolated."""
RUNNING = 2.2
"""Metres a second from which on both feet leave the ground."""
STRETCH = 0.985
"""A leg is never straighter than this share of its length."""


@dataclass(frozen=True)
class Manner:
    """What makes one walk differ from another."""

    stride: float = 1.0
    """Factor on the length of steps."""
    lean: float = 0.02
    """Of the trunk, forward, rad."""
    bow: float = 0.0
    """Of the head, forward, rad."""
    swing: float = 1.0
    """Factor on how far the arms swing."""
    elbow: float = 0.25
    """Least bend of the elbows, rad."""
    bounce: float = 1.0
    """Factor on how far the hips rise and sink."""
    width: float = 0.8
    """Of the track, where 1 is that of the hips."""
    spread: float = 0.12
    """Of the arms from the body, rad."""


PLAIN = Manner()
SHY = Manner(
    stride=0.74, lean=0.13, bow=0.42, swing=0.35, elbow=0.55, bounce=0.6, width=0.6, spread=0.04
)
HURRIED = Manner(
    stride=1.1, lean=0.17, bow=-0.06, swing=1.6, elbow=0.95, bounce=1.2, width=0.7, spread=0.2
)


@dataclass(frozen=True)
class Gait:
    """One cycle of walking or running."""

    poses: Poses
    """`PHASES` moments, evenly spaced from phase 0; the first follows on the last."""
    strokes: Array
    """Shape (PHASES, 2): where each foot is between its farthest ahead and behind, in strides.

    It falls by as much as the phase rises while the foot stands.
    """
    duties: Array
    """Shape (2,): share of the cycle that each foot stands."""
    stride_m: float
    """Metres a cycle at size 1."""
    speed: float
    """Metres a second at which it looks right, at size 1."""


def gait(speed: float, manner: Manner = PLAIN) -> Gait:
    """The shipped gait at `speed` in m/s; at 0 it steps on the spot."""
    runs = speed >= RUNNING
    brisk = min(speed / 1.3, 1.0)
    stride = stride_at(speed, manner)
    duty = float(np.clip(0.44 - 0.03 * speed, 0.28, 0.4) if runs else 0.64 - 0.03 * speed)
    phase = np.arange(PHASES) / PHASES
    legs = [
        _leg(np.mod(phase - start, 1.0), duty, stride, brisk, runs, speed) for start in (0, 0.5)
    ]
    strokes = np.stack([leg[0] for leg in legs], axis=1)
    pitch = np.stack([leg[2] for leg in legs], axis=1)
    ankles = np.zeros((PHASES, 2, 3))
    ankles[:, :, 0] = np.stack([leg[1][:, 0] for leg in legs], axis=1)
    ankles[:, :, 1] = np.array([1, -1]) * HALF_HIPS * manner.width * (0.6 if runs else 1.0)
    ankles[:, :, 2] = np.stack([leg[1][:, 1] for leg in legs], axis=1)
    feet = product(about(2, np.array([0.1, -0.1])), about(1, pitch))
    standing = np.stack([np.mod(phase - start, 1.0) < duty for start in (0, 0.5)], axis=1)
    upper, sway = _upper(phase, speed, brisk, runs, manner)
    root = np.stack([np.full(PHASES, 0.02 * brisk), sway, np.zeros(PHASES)], axis=1)
    top = highest(root, upper[:, 0], ankles, standing)
    middle = duty / 2  # of the stance: walking is highest there, running lowest
    bob = np.cos(4 * np.pi * (phase - middle)) * manner.bounce
    bob *= -0.035 if runs else 0.006 + 0.012 * brisk
    root[:, 2] = bob + (top - bob).min()
    hinges = np.broadcast_to(np.array([[-0.1, 1.0, 0.0], [0.1, 1.0, 0.0]]), (PHASES, 2, 3))
    return Gait(
        Poses(root, upper, ankles, feet, np.array(hinges)), strokes, np.full(2, duty), stride, speed
    )


def stride_at(speed: float, manner: Manner = PLAIN) -> float:
    """Metres a cycle at `speed` m/s, at size 1."""
    return manner.stride * (0.62 + (0.5 if speed >= RUNNING else 0.54) * speed)


def highest(root: Array, hips: Array, ankles: Array, standing: NDArray[np.bool_]) -> Array:
    """How high the hips can be (F,) without tearing off a foot that stands (F, 2)."""
    sockets = root[:, None] + rotated(hips[:, None], HIPS)
    away = ((sockets - ankles)[..., :2] ** 2).sum(axis=-1)
    reach = np.sqrt(np.maximum((STRETCH * (THIGH + SHANK)) ** 2 - away, 0.1))
    top = ankles[..., 2] + reach - (sockets - root[:, None])[..., 2]
    return np.asarray(np.where(standing, top, np.inf).min(axis=1))


def stroke(phase: Array, duty: float) -> Array:
    """Where a foot is between its farthest ahead and behind, in strides; `phase` from touchdown.

    While it stands it falls as the phase rises; then it swings ahead, and already comes back at
    the ground's speed as it touches down.
    """
    swing = np.clip((phase - duty) / (1 - duty), 0.0, 1.0)
    back = 3 * swing**2 - 2 * swing**3
    slope = 2 * swing**3 - 3 * swing**2 + swing
    return np.where(phase < duty, duty / 2 - phase, (back - 0.5) * duty - slope * (1 - duty))


def clearance(swing: Array) -> Array:
    """Least height of a swinging sole, m: it lifts and lands steeply, so as not to skim."""
    return np.asarray(0.05 * np.sin(np.pi * np.clip(swing, 0.0, 1.0)) ** 0.7)


def _leg(
    phase: Array, duty: float, stride: float, brisk: float, runs: bool, speed: float
) -> tuple[Array, Array, Array]:
    """Stroke (F,), ankle ahead and up (F, 2) and pitch of the foot (F,), toes down positive."""
    swing = np.clip((phase - duty) / (1 - duty), 0.0, 1.0)
    back = 3 * swing**2 - 2 * swing**3
    raised = (0.05 if runs else 0.3) * brisk
    pushed = (0.85 if runs else 0.7) * brisk + (0.0 if runs else 0.1)
    flat = 0.35 if runs else 0.55
    knots = np.array([0.0, 0.14, flat, 1.0, 1.35, 1.8, 2.0])
    pitches = np.array([-raised, 0.0, 0.0, pushed, pushed * 1.1, -0.1 * brisk, -raised])
    pitch = PchipInterpolator(knots, pitches)(np.where(phase < duty, phase / duty, 1 + swing))
    # While it stands, the foot turns about its heel, then about its ball.
    rolled = _rolled(pitch)
    ends = _rolled(np.array([pushed, -raised]))
    free = ends[0] + back[:, None] * (ends[1] - ends[0])
    lift = 0.05 + 0.05 * brisk
    if runs:
        lift = 0.13 + 0.05 * speed
    free[:, 1] += lift * np.sin(np.pi * swing ** (0.8 if runs else 0.75)) ** 1.2
    place = np.where((phase < duty)[:, None], rolled, free)
    soles = rotated(about(1, pitch)[:, None], SOLES)[..., 2].min(axis=1) + place[:, 1] + ANKLE
    clear = np.where(phase < duty, 0.0, clearance(swing))
    place[:, 1] += np.maximum(clear - soles, 0.0)
    stroked = stroke(phase, duty)
    place[:, 0] += stroked * stride - (0.05 if runs else 0.06) * brisk
    place[:, 1] += ANKLE
    return stroked, place, pitch


def _rolled(pitch: Array) -> Array:
    """How far the ankle moves ahead and up (F, 2) as a standing foot pitches about heel or ball."""
    pivot = np.where((pitch < 0)[:, None], SOLES[0], SOLES[1])
    moved: Array = pivot - rotated(about(1, pitch), pivot)
    return moved[:, [0, 2]]


def _upper(
    phase: Array, speed: float, brisk: float, runs: bool, manner: Manner
) -> tuple[Array, Array]:
    """Rotations of the upper body (F, 9, 4), and how far the hips sway to the left (F,)."""
    beat, quarter = np.cos(2 * np.pi * phase), np.sin(2 * np.pi * phase)
    twist = 0.13 * brisk
    lean = manner.lean * (0.5 + 0.5 * brisk) + (0.16 if runs else 0.03 * brisk)
    hips = product(
        about(2, -twist * beat),
        product(about(1, np.full_like(beat, 0.3 * lean)), about(0, 0.05 * quarter)),
    )
    chest = product(
        about(2, (1.0 + 0.8 * manner.swing) * twist * beat),
        product(
            about(1, 0.7 * lean + 0.015 * np.cos(4 * np.pi * phase)), about(0, -0.06 * quarter)
        ),
    )
    head = product(
        about(2, -0.8 * manner.swing * twist * beat),
        about(1, manner.bow - 0.6 * lean - 0.015 * np.cos(4 * np.pi * phase)),
    )
    reach = manner.swing * (0.62 if runs else 0.06 + 0.36 * brisk)
    elbow = manner.elbow + (1.1 if runs else 0.1 * brisk)
    parts = [hips, chest, head]
    fore, hands = [], []
    for side in (1, -1):
        swung = side * beat * reach + (0.12 if runs else -0.02)
        parts.append(product(about(1, swung), about(0, side * np.full_like(beat, manner.spread))))
        bend = np.minimum(elbow + 0.5 * np.maximum(-side * beat, -0.4) * reach, 2.0)
        fore.append(product(about(2, -side * np.full_like(beat, 0.25)), about(1, -bend)))
        hands.append(about(1, -0.1 - 0.15 * side * beat * reach))
    sway = (0.045 - 0.025 * brisk) * quarter * (0.3 if runs else 1.0)
    return np.stack([*parts, *fore, *hands], axis=1), sway
