"""Rocks that tumble through space, and the dust between them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import trimesh

from evastudio.world.bodies import Body, Mesh
from evastudio.world.geometry import quaternions_from_euler
from evastudio.world.spaces import Array

ROCKS: tuple[str, ...] = ("rock_a", "rock_b", "rock_c", "rock_d")


@lru_cache(maxsize=4)
def tumbled(count: int) -> Array:
    """How `count` rocks lie: quaternions (count, 4)."""
    spin = np.random.default_rng(count).uniform(-np.pi, np.pi, (count, 3))
    return quaternions_from_euler(*spin.T)


@lru_cache(maxsize=4)
def dust(length: float, half: float) -> Body:
    """Motes in the light of a corridor, `length` and twice `half` metres: they show one's speed."""
    rng = np.random.default_rng(7)
    places = rng.uniform((-20.0, -half, -half), (length + 80.0, half, half), (6000, 3))
    wxyzs = np.tile((1.0, 0.0, 0.0, 0.0), (len(places), 1))
    return Body("dust", "mote", places, wxyzs, rng.uniform(0.02, 0.045, len(places)), fixed=True)


def rock_bodies(rocks: Array, radius: float) -> list[Body]:
    """Boulders of `radius` metres at `rocks` (N, 3); they stay where they are."""
    wxyzs, scales, kinds = tumbled(len(rocks)), np.full(len(rocks), radius), len(ROCKS)
    return [
        Body(name, name, rocks[kind::kinds], wxyzs[kind::kinds], scales[kind::kinds], True)
        for kind, name in enumerate(ROCKS)
    ]


def mote_mesh() -> Mesh:
    """A grain that shines."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=np.float64)
    return Mesh(
        corners, np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]), (168, 190, 235), glow=True
    )


def rock_meshes() -> dict[str, Mesh]:
    """Four chipped boulders of radius 1, within the sphere that collides."""
    colors = ((122, 108, 98), (98, 94, 100), (138, 112, 92), (108, 100, 92))
    meshes: dict[str, Mesh] = {}
    for number, (name, color) in enumerate(zip(ROCKS, colors, strict=True)):
        rng = np.random.default_rng(number)
        ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
        points = np.asarray(ball.vertices, dtype=np.float64) + rng.normal(0, 0.035, (162, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        cuts = rng.normal(size=(20, 3))
        cuts /= np.linalg.norm(cuts, axis=1, keepdims=True)
        depth = rng.uniform(0.8, 0.95, 20)
        facing = np.maximum(points @ cuts.T, 1e-9)
        radius = np.minimum((depth / facing).min(axis=1), 1.0)
        craters = np.exp(-((1.0 - points @ cuts[:4].T) / 0.03)) * 0.09
        radius *= (1.0 - craters.sum(axis=1)) * rng.uniform(0.985, 1.0, len(points))
        meshes[name] = Mesh(
            points * radius[:, None], np.asarray(ball.faces, dtype=np.int64), color, flat=True
        )
    return meshes
