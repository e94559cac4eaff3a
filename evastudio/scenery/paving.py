"""A paved square without an edge, for people to walk about on."""

from __future__ import annotations

import numpy as np

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

SLAB = 1.4
"""Metres from joint to joint."""
JOINTS = 20
"""To each side of where one looks."""


def paving_meshes() -> dict[str, Mesh]:
    """The square and the joints between its slabs."""
    square = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float64)
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    return {
        "paving": Mesh(square, faces, (200, 192, 178), flat=True),
        "joint": Mesh(square * (0.5, 0.02, 1.0), faces, (152, 144, 132), flat=True),
    }


def paving_bodies(here: Array) -> list[Body]:
    """The paving around `here` (2,), moving on by whole slabs so that it seems to stay."""
    x, y = np.rint(here / SLAB) * SLAB
    level = np.array([(1.0, 0.0, 0.0, 0.0)])
    across = np.array([(np.cos(np.pi / 4), 0.0, 0.0, np.sin(np.pi / 4))])
    line = (np.arange(-JOINTS, JOINTS + 1) - 0.5) * SLAB
    east = np.stack([np.full(len(line), x), y + line, np.full(len(line), 0.004)], axis=1)
    north = np.stack([x + line, np.full(len(line), y), np.full(len(line), 0.004)], axis=1)
    turns = np.concatenate([np.repeat(level, len(line), 0), np.repeat(across, len(line), 0)])
    scales = np.tile((2 * JOINTS * SLAB, 1.0, 1.0), (len(turns), 1))
    return [
        Body("paving", "paving", np.array([(x, y, 0.0)]), level, np.full(1, 150.0)),
        Body("joints", "joint", np.concatenate([east, north]), turns, scales),
    ]
