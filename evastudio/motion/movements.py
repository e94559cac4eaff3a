"""Recordings that are no gait, as movements of the shipped body: standing, falling, getting up."""

from __future__ import annotations

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.keyposes import RATE_HZ
from evastudio.motion.poses import Poses

LONGEST_S = 20.0


def movement_of(poses: Poses, rate_hz: float, name: str, repeats: bool = False) -> Poses:
    """`poses` at the rate that figures play them; `repeats` makes the end lead to the beginning.

    Raises InvalidInputError for a clip that lasts longer than an activity does.
    """
    length_s = (len(poses) - 1) / rate_hz
    if length_s > LONGEST_S:
        raise InvalidInputError(
            f"Clip {name!r} lasts {length_s:.0f} s; for this activity it may last "
            f"{LONGEST_S:.0f} s. Export the part that is meant."
        )
    count = max(2, round(length_s * RATE_HZ) + 1)
    path = poses.at(np.linspace(0.0, len(poses) - 1, count))
    return closed(path) if repeats else path


def closed(path: Poses) -> Poses:
    """`path` on the spot, its last moment made equal to its first without a jump between."""
    share = np.linspace(0.0, 1.0, len(path))
    travel = path.root[-1] - path.root[0]
    away = path.root[0] * (1, 1, 0) + share[:, None] * travel
    away[:, 2] = share * travel[2]
    level = [path.root - away, path.upper, path.ankles - away[:, None], path.feet, path.hinges]
    for number, array in enumerate(level):
        weight = share.reshape(-1, *[1] * (array.ndim - 1))
        level[number] = array - weight * (array[-1] - array[0])
    return Poses(*level)
