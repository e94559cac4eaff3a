"""Where on the ground a person points at in a view."""

from __future__ import annotations

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.world.bodies import FIELD_OF_VIEW, Camera

FARTHEST = 200.0
"""Metres from the camera within which a place can be pointed at."""


def ground_at(camera: Camera, across: float, up: float, aspect: float) -> tuple[float, float]:
    """x and y of the ground (z = 0) seen at a place in the view of `camera`, metres.

    across, up: from -1 at the left and the bottom to 1. aspect: the view's width over its height.
    Raises InvalidInputError where no ground is seen there.
    """
    ahead = camera.look_at - camera.position
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up)
    right = right / np.linalg.norm(right)
    reach = np.tan(FIELD_OF_VIEW / 2)
    ray = ahead + reach * (aspect * across * right + up * np.cross(right, ahead))
    ray = ray / np.linalg.norm(ray)
    if ray[2] >= 0.0 or -camera.position[2] / ray[2] > FARTHEST:
        raise InvalidInputError("There is no ground where you point; point lower.")
    x, y, _ = camera.position - ray * (camera.position[2] / ray[2])
    return float(x), float(y)
