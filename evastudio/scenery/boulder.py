"""A boulder that falls from the sky, how long it takes, and what to draw of it and its dust."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

FALL_S = 1.0
"""From letting the boulder go to its impact."""
HEIGHT = 22.0
"""Metres that it falls."""
BOULDER = 1.6
"""Its radius, metres."""
PUFFS = 60


def falling(boulder: Array, asked: NDArray[np.bool_], where: Array, dt_s: float) -> Array:
    """Boulders (worlds, 3) a step later; where one is `asked` for and there is none, it is let go.

    where: what it is to hit, (worlds, 2).
    """
    begins = asked & (boulder[:, 2] < 0.0)
    later = boulder + np.where(boulder[:, 2:] < 0.0, 0.0, dt_s) * (0.0, 0.0, 1.0)
    let_go = np.concatenate([where, np.zeros((len(where), 1))], axis=1)
    return np.where(begins[:, None], let_go, later)


@lru_cache(maxsize=1)
def _rock() -> Mesh:
    """A chipped rock of radius 1."""
    rng = np.random.default_rng(4)
    ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
    cuts = rng.normal(size=(24, 3))
    cuts /= np.linalg.norm(cuts, axis=1, keepdims=True)
    depth = rng.uniform(0.8, 0.97, 24)
    points = np.asarray(ball.vertices, dtype=np.float64)
    radius = np.minimum((depth / np.maximum(points @ cuts.T, 1e-9)).min(axis=1), 1.0)
    faces = np.asarray(ball.faces, dtype=np.int64)
    return Mesh(points * radius[:, None], faces, (112, 100, 92), flat=True)


def _puff() -> Mesh:
    """A clod of dust of radius 1."""
    ball = trimesh.creation.icosphere(subdivisions=1, radius=1.0)
    return Mesh(np.asarray(ball.vertices), np.asarray(ball.faces), (190, 176, 152), flat=True)


def boulder_meshes() -> dict[str, Mesh]:
    """The boulder and a clod of dust."""
    return {"boulder": _rock(), "dust": _puff()}


def boulder_bodies(boulder: Array) -> list[Body]:
    """The boulder on its way down or at rest, and the dust of its impact.

    boulder: shape (3,): where it comes down, x and y, and seconds since it was let go, below zero
    while there is none.
    """
    x, y, since = boulder
    if since < 0.0:
        return []
    left = max(1.0 - (since / FALL_S) ** 2, 0.0)
    spin = 1.7 * min(since, FALL_S)
    turn = np.array([(np.cos(spin), 0.6 * np.sin(spin), 0.8 * np.sin(spin), 0.0)])
    at = np.array([(x, y, 0.75 * BOULDER + HEIGHT * left)])
    bodies = [Body("boulder", "boulder", at, turn, np.full(1, BOULDER))]
    age = since - FALL_S
    if 0.0 <= age < 4.0:
        rng = np.random.default_rng(11)
        bearing, pace = rng.uniform(-np.pi, np.pi, PUFFS), rng.uniform(0.4, 1.0, PUFFS)
        out = BOULDER * 0.7 + 4.5 * pace * (1.0 - np.exp(-1.6 * age))
        high = 0.1 + rng.uniform(0.2, 1.5, PUFFS) * (1.0 - np.exp(-1.2 * age))
        size = 0.55 * rng.uniform(0.5, 1.0, PUFFS) * np.minimum(4.0 * age + 0.2, 1.0)
        size = size * np.clip(1.0 - age / 4.0, 0.0, 1.0)
        places = np.stack([x + out * np.cos(bearing), y + out * np.sin(bearing), high], axis=1)
        turns = np.tile((1.0, 0.0, 0.0, 0.0), (PUFFS, 1))
        bodies.append(Body("dust", "dust", places, turns, size))
    return bodies
