"""Ground on which one can walk, as cells that are free: felt for, read from recordings, drawn.

Worlds with it hold `ground` (H, W), 1 where one can walk, (1, 1) for everywhere, and `corner` (2,),
where it begins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Mesh
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

CELL = 0.2
"""Metres from cell to cell of the ground."""
RAYS = np.radians([0.0, 45.0, -45.0, 90.0, -90.0])
"""Ways from that to the goal along which the free ground is perceived."""
FEELS = np.arange(1, 21) * 0.1
"""Metres at which it is looked for along each."""
MARGIN = 3.0
"""Metres around a recorded lead's way in which the ground is known."""


def clearances(snapshot: Snapshot, bearing: Array) -> Array:
    """Metres of free ground along each of RAYS from `bearing` (worlds, N); (worlds, N, rays)."""
    ground = snapshot["ground"]
    worlds, high, wide = ground.shape
    if (high, wide) == (1, 1):
        return np.full((*bearing.shape, len(RAYS)), FEELS[-1])
    angle = bearing[..., None] + RAYS
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=3)[..., None, :] * FEELS[:, None]
    start = snapshot["position"] - snapshot["corner"][:, None]
    cells = np.floor((start[:, :, None, None] + ray) / CELL).astype(np.int64)
    x, y = cells[..., 0], cells[..., 1]
    inside = (x >= 0) & (x < wide) & (y >= 0) & (y < high)
    world = np.arange(worlds)[:, None, None, None]
    free = inside & (ground[world, y.clip(0, high - 1), x.clip(0, wide - 1)] > 0)
    steps = np.where(free.all(axis=3), len(FEELS), free.argmin(axis=3))
    return np.asarray(np.concatenate([[0.0], FEELS])[steps])


def ground_of(points: Array, path: Array) -> tuple[NDArray[np.uint8], Array]:
    """The cells (H, W) at and beside `points` (M, 2) near a `path` (steps, 2), and their corner.

    One free cell, which stands for everywhere, where there are no points.
    """
    low, high = np.nanmin(path, axis=0) - MARGIN, np.nanmax(path, axis=0) + MARGIN
    points = points[((points > low) & (points < high)).all(axis=1)]
    if len(points) == 0:
        return np.ones((1, 1), dtype=np.uint8), low
    wide, tall = np.ceil((high - low) / CELL).astype(np.int64)
    x, y = np.floor((points - low) / CELL).astype(np.int64).T
    cells = np.zeros((tall + 2, wide + 2), dtype=np.uint8)
    for across in range(3):
        for along in range(3):
            cells[y + along, x + across] = 1
    return cells[1:-1, 1:-1], low


def kerb_mesh() -> Mesh:
    """A stone, a metre wide and high."""
    corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * (0.5, 0.5, 1.0)
    points = np.concatenate([corners, corners + np.array([0.0, 0.0, 1.0])])
    rims = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    squares = [*rims, (4, 5, 6, 7)]
    faces = np.array([three for a, b, c, d in squares for three in ((a, b, c), (a, c, d))])
    return Mesh(points, faces, (150, 144, 134), flat=True)


def kerb_bodies(world: Snapshot) -> list[Body]:
    """Stones along the edge of the ground, where it has one."""
    ground = world["ground"][0]
    if ground.shape == (1, 1):
        return []
    inner = np.pad(ground, 2)
    beside = inner[:-2, 1:-1] | inner[2:, 1:-1] | inner[1:-1, :-2] | inner[1:-1, 2:]
    y, x = np.nonzero((inner[1:-1, 1:-1] == 0) & (beside > 0))
    cells = np.stack([x - 0.5, y - 0.5], axis=1) * CELL + world["corner"][0]
    places = np.column_stack([cells, np.zeros(len(cells))])
    upright = np.tile((1.0, 0.0, 0.0, 0.0), (len(cells), 1))
    return [Body("kerb", "kerb", places, upright, np.tile((CELL, CELL, 0.12), (len(cells), 1)))]
