"""Where a corridor through space ends: a lattice of thin bars on its four walls."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

APART = 20.0
"""Metres from one bar to the next, at most: somebody near a wall always has some in sight."""
WIDE = 0.16
"""Metres that a bar is wide."""


@lru_cache(maxsize=4)
def bounds(length: float, half: float) -> Body:
    """The walls of a corridor, `length` metres long and `half` to each side: frames across it, and
    bars along it."""
    along = _steps(0.0, length)
    aside = _steps(-half, half)
    edges = [
        (y, z)
        for y, z in np.stack(np.meshgrid(aside, aside), axis=-1).reshape(-1, 2)
        if half in (abs(y), abs(z))
    ]
    places = [(length / 2, y, z) for y, z in edges]
    scales = [(length, WIDE, WIDE)] * len(edges)
    for x in along:
        places += [(x, side, 0.0) for side in (-half, half)]
        scales += [(WIDE, WIDE, 2 * half)] * 2
        places += [(x, 0.0, side) for side in (-half, half)]
        scales += [(WIDE, 2 * half, WIDE)] * 2
    level = np.tile((1.0, 0.0, 0.0, 0.0), (len(places), 1))
    return Body("bounds", "bar", np.array(places), level, np.array(scales), fixed=True)


def bar_mesh() -> Mesh:
    """A cube of 1 m that shines a little, to be drawn out into bars."""
    sides = np.array([-0.5, 0.5])
    corners = np.stack(np.meshgrid(sides, sides, sides, indexing="ij"), axis=-1).reshape(-1, 3)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [three for a, b, c, d in squares for three in ((a, b, c), (a, c, d))]
    return Mesh(corners, np.array(faces), (164, 104, 84), glow=True)


def _steps(first: float, last: float) -> Array:
    """From `first` to `last` in equal steps of `APART` at most."""
    return np.linspace(first, last, int(np.ceil((last - first) / APART)) + 1)
