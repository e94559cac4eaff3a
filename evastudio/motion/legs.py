"""Two-bone inverse kinematics: knees for feet that are where they should be."""

from __future__ import annotations

import numpy as np

from evastudio.motion.body import SHANK, THIGH
from evastudio.motion.rotations import (
    Numbers,
    about,
    components,
    from_axes,
    joined,
    normalized,
    product,
)

LONGEST = 0.9995 * (THIGH + SHANK)
SHORTEST = 0.35 * (THIGH + SHANK)


def legs(
    sockets: Numbers, ankles: Numbers, hinges: Numbers
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Knees and ankles (..., 3), and orientations of thighs and shanks (..., 4).

    `sockets` and `ankles` (..., 3) are where the legs hang and where they should end, `hinges`
    (..., 3) about which axes the knees should bend. A foot out of reach is drawn nearer.
    """
    dx, dy, dz = components(sockets - ankles)
    far = np.sqrt(dx * dx + dy * dy + dz * dz)
    length = np.clip(far, SHORTEST, LONGEST)
    scale = 1 / np.maximum(far, 1e-6)
    ux, uy, uz = dx * scale, dy * scale, dz * scale
    hx, hy, hz = components(hinges)
    along = hx * ux + hy * uy + hz * uz
    left = normalized(joined(hx - along * ux, hy - along * uy, hz - along * uz))
    lx, ly, lz = components(left)
    up = joined(ux, uy, uz)
    ahead = joined(ly * uz - lz * uy, lz * ux - lx * uz, lx * uy - ly * ux)
    leg = from_axes(ahead, left, up)
    square = length * length
    at_hip = (THIGH**2 + square - SHANK**2) / (2 * THIGH * length)
    at_foot = (SHANK**2 + square - THIGH**2) / (2 * SHANK * length)
    hip, foot = np.arccos(np.minimum(at_hip, 1.0)), np.arccos(np.minimum(at_foot, 1.0))
    sine = THIGH * np.sqrt(np.maximum(1 - at_hip * at_hip, 0))
    knees = sockets - up * (THIGH * at_hip)[..., None] + ahead * sine[..., None]
    reached = sockets - up * length[..., None]
    return knees, reached, product(leg, about(1, -hip)), product(leg, about(1, foot))


def too_high(sockets: Numbers, ankles: Numbers) -> Numbers:
    """How much nearer the ground `sockets` (..., 3) must be to reach the ankles; may be below 0."""
    dx, dy, dz = components(sockets - ankles)
    return np.asarray(dz - np.sqrt(np.maximum(LONGEST**2 - dx * dx - dy * dy, 0.1)))
