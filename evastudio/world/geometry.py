"""Angles, directions and quaternions (wxyz), for batches."""

from __future__ import annotations

import numpy as np

from evastudio.world.spaces import Array


def columns(*parts: Array) -> Array:
    """`parts`, all of shape (...), side by side: shape (..., len(parts)).

    `np.stack` along the last axis, without the checks that cost more than the numbers of one world.
    """
    together = np.empty((*parts[0].shape, len(parts)))
    for column, part in enumerate(parts):
        together[..., column] = part
    return together


def directions(heading: Array) -> Array:
    """Unit vectors, shape (..., 3), for yaw and pitch `heading` of shape (..., 2), rad."""
    yaw, pitch = heading[..., 0], heading[..., 1]
    flat = np.cos(pitch)
    return columns(flat * np.cos(yaw), flat * np.sin(yaw), np.sin(pitch))


def quaternions_from_euler(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Unit quaternions wxyz, shape (N, 4), of intrinsic yaw, then pitch, then roll, rad.

    Positive pitch turns x towards -z (right-handed about y).
    """
    cr, sr = np.cos(roll / 2), np.sin(roll / 2)
    cp, sp = np.cos(pitch / 2), np.sin(pitch / 2)
    cy, sy = np.cos(yaw / 2), np.sin(yaw / 2)
    return columns(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
