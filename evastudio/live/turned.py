"""How one camera looks to another, so that several views can be turned as one."""

from __future__ import annotations

import numpy as np

from evastudio.world.bodies import Camera
from evastudio.world.spaces import Array

FARTHEST_M = 1e6
"""A camera turned to further away from where it was is not followed."""


def as_seen(camera: Camera, told: Camera) -> Camera:
    """`told` in the frame of `camera`: x along its sight, z up in its picture."""
    axes = _axes(camera)
    return Camera(
        position=(told.position - camera.position) @ axes,
        look_at=(told.look_at - camera.position) @ axes,
        up=told.up @ axes,
    )


def placed(camera: Camera, seen: Camera) -> Camera:
    """Where `seen`, a camera in the frame of `camera`, is in the world: undoes `as_seen`."""
    axes = _axes(camera).T
    return Camera(
        position=camera.position + seen.position @ axes,
        look_at=camera.position + seen.look_at @ axes,
        up=seen.up @ axes,
    )


def is_near(camera: Camera, other: Camera) -> bool:
    """Whether both are in the same part of the world, so that one can be turned into the other."""
    points = np.stack([other.position, other.look_at]) - camera.position
    return bool((np.abs(points) < FARTHEST_M).all())


def _axes(camera: Camera) -> Array:
    """Forward, left and up of `camera` as columns, (3, 3), in the world's frame."""
    forward = np.asarray(camera.look_at, dtype=np.float64) - camera.position
    forward = _unit(forward, np.array([1.0, 0.0, 0.0]))
    left = np.cross(camera.up, forward)
    if np.linalg.norm(left) < 1e-9:  # it looks straight up or down
        left = np.cross([0.0, 1.0, 0.0] if abs(forward[1]) < 0.9 else [0.0, 0.0, 1.0], forward)
    left = _unit(left, np.array([0.0, 1.0, 0.0]))
    return np.stack([forward, left, np.cross(forward, left)], axis=1)


def _unit(vector: Array, otherwise: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return otherwise if length < 1e-9 else np.asarray(vector / length)
