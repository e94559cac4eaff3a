"""A small racer: its hull, its glass, two engines and their flames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

SHIP: tuple[str, ...] = ("hull", "canopy", "trim", "engines")
FLAMES: tuple[str, ...] = ("flame", "core")
Ring = tuple[float, float, float, float, float]
"""Of a hull: x, half width, half height, y and z of its centre."""
Solid = tuple[Array, NDArray[np.int64]]
"""Vertices (V, 3) and faces (F, 3)."""


def ship_bodies(place: Array, pose: Array) -> list[Body]:
    """The ship at `place` (1, 3), turned by `pose`, a quaternion (1, 4). Flames flicker."""
    flicker = 1.0 + 0.08 * np.sin(place[:, 0] * 7.0) + 0.06 * np.sin(place[:, 0] * 17.0)
    parts = [Body(name, name, place, pose, np.ones(1)) for name in SHIP]
    return [*parts, *(Body(name, name, place, pose, flicker) for name in FLAMES)]


def ship_meshes() -> dict[str, Mesh]:
    """A small racer, 3.4 m long: pale hull, glass, orange trim, two engines and their flames."""
    body = [
        (1.9, 0.03, 0.02, 0.0, -0.1),
        (1.0, 0.22, 0.14, 0.0, -0.05),
        (0.1, 0.36, 0.27, 0.0, 0.0),
        (-0.9, 0.40, 0.28, 0.0, 0.02),
        (-1.4, 0.26, 0.18, 0.0, 0.05),
    ]
    glass = [
        (0.95, 0.04, 0.03, 0.0, 0.1),
        (0.45, 0.17, 0.13, 0.0, 0.19),
        (-0.1, 0.2, 0.16, 0.0, 0.24),
        (-0.7, 0.08, 0.05, 0.0, 0.28),
    ]
    pod = [
        (-0.2, 0.1, 0.1, 0.62, -0.1),
        (-0.45, 0.2, 0.18, 0.62, -0.1),
        (-1.3, 0.2, 0.18, 0.62, -0.1),
        (-1.45, 0.15, 0.13, 0.62, -0.1),
    ]
    wing = [(0.5, 0.25, -0.1), (-1.1, 0.25, -0.1), (-1.25, 1.55, -0.3), (-0.75, 1.55, -0.3)]
    tip = [(-0.35, 1.5, -0.31), (-1.5, 1.5, -0.31), (-1.5, 1.72, -0.34), (-0.8, 1.72, -0.34)]
    fin = [(-0.5, 0.3, 0.1), (-1.3, 0.3, 0.1), (-1.65, 0.62, 0.75), (-1.3, 0.62, 0.75)]

    def jet(length: float, wide: float) -> Sequence[Ring]:
        return [
            (-1.44, wide, wide, 0.62, -0.1),
            (-1.44 - 0.3 * length, 0.85 * wide, 0.85 * wide, 0.62, -0.1),
            (-1.44 - length, 0.01, 0.01, 0.62, -0.1),
        ]

    return {
        "hull": joined((214, 220, 230), loft(body, 8), *both(plate(wing, 0.1))),
        "canopy": joined((24, 70, 110), loft(glass, 8)),
        "trim": joined((244, 92, 40), *both(plate(tip, 0.14)), *both(plate(fin, 0.07))),
        "engines": joined((96, 104, 120), *both(loft(pod, 10))),
        "flame": joined((70, 150, 255), *both(loft(jet(1.1, 0.13), 8)), glow=True),
        "core": joined((220, 244, 255), *both(loft(jet(0.5, 0.15), 8)), glow=True),
    }


def loft(rings: Sequence[Ring], sides: int) -> Solid:
    """A closed skin through `rings`, from bow to stern."""
    angle = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    skin = [
        np.stack([np.full(sides, x), y + wide * np.cos(angle), z + high * np.sin(angle)], axis=1)
        for x, wide, high, y, z in rings
    ]
    faces: list[tuple[int, int, int]] = []
    last = (len(rings) - 1) * sides
    for start in range(0, last, sides):
        for side in range(sides):
            a, b = start + side, start + (side + 1) % sides
            faces += [(a, a + sides, b), (b, a + sides, b + sides)]
    for side in range(1, sides - 1):
        faces += [(0, side, side + 1), (last, last + side + 1, last + side)]
    return np.concatenate(skin), np.array(faces)


def plate(outline: Sequence[tuple[float, float, float]], thick: float) -> Solid:
    """A convex plate, `thick` metres from top to bottom."""
    points = np.array(outline)
    hull = trimesh.convex.convex_hull(np.concatenate([points, points + np.array((0, 0, thick))]))
    return np.asarray(hull.vertices), np.asarray(hull.faces)


def both(solid: Solid) -> tuple[Solid, Solid]:
    """`solid` and its mirror image on the ship's other side."""
    return solid, (solid[0] * (1.0, -1.0, 1.0), np.flip(solid[1], axis=1))


def joined(color: tuple[int, int, int], *solids: Solid, glow: bool = False) -> Mesh:
    """One mesh of `solids`."""
    starts = np.cumsum([0, *(len(points) for points, _ in solids)])
    faces = [faces + start for (_, faces), start in zip(solids, starts, strict=False)]
    points = np.concatenate([points for points, _ in solids]).astype(np.float64)
    return Mesh(points, np.concatenate(faces).astype(np.int64), color, flat=True, glow=glow)
