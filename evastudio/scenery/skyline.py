"""Houses in the haze around a place: they tell which way one turns, and where the ground ends."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

HOUSES = 46
NEAR, FAR = 82.0, 106.0
"""Metres from where one stands."""
CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
SIDES = np.array(
    [
        *((4, 5, 7), (4, 7, 6)),
        *((0, 1, 5), (0, 5, 4)),
        *((1, 3, 7), (1, 7, 5)),
        *((3, 2, 6), (3, 6, 7)),
        *((2, 0, 4), (2, 4, 6)),
    ]
)
"""A box without its floor."""


@lru_cache(maxsize=1)
def skyline_mesh() -> Mesh:
    """All of them in one mesh."""
    rng = np.random.default_rng(7)
    around = 2 * np.pi * (np.arange(HOUSES) + rng.uniform(-0.3, 0.3, HOUSES)) / HOUSES
    far = rng.uniform(NEAR, FAR, HOUSES)
    half = np.stack([rng.uniform(4, 7, HOUSES), rng.uniform(4, 9, HOUSES)], axis=1)
    high = rng.gamma(3.0, 3.0, HOUSES).clip(4.0, 24.0)
    cos, sin = np.cos(around), np.sin(around)
    boxes: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    for i in range(HOUSES):
        x, y, z = (CORNERS * (*half[i], high[i])).T
        x = x + far[i]
        boxes.append(np.stack([cos[i] * x - sin[i] * y, sin[i] * x + cos[i] * y, z], axis=1))
        faces.append(SIDES + len(CORNERS) * i)
    return Mesh(np.concatenate(boxes), np.concatenate(faces), (196, 188, 184), flat=True)


def skyline_body(here: Array) -> Body:
    """The houses around `here` (2,): so far off that they stay where they are seen."""
    level = np.array([(1.0, 0.0, 0.0, 0.0)])
    return Body("skyline", "skyline", np.array([(*here, 0.0)]), level, np.ones(1))
