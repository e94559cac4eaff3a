"""Angles, directions and quaternions (wxyz), for batches."""

from __future__ import annotations

import numpy as np

from evastudio.world.spaces import Array


def directions(heading: Array) -> Array:
    """Unit vectors, shape (..., 3), for yaw and pitch `heading` of shape (..., 2), rad."""
    yaw, pitch = heading[..., 0], heading[..., 1]
    flat = np.cos(pitch)
    return np.stack([flat * np.cos(yaw), flat * np.sin(yaw), np.sin(pitch)], axis=-1)


def quaternions_from_euler(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Unit quaternions wxyz, shape (N, 4), of intrinsic yaw, then pitch, then roll, rad.

    Positive pitch turns x towards -z (right-handed about y).
    """
    cr, sr = np.cos(roll / 2), np.sin(roll / 2)
    cp, sp = np.cos(pitch / 2), np.sin(pitch / 2)
    cy, sy = np.cos(yaw / 2), np.sin(yaw / 2)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )
