"""A painter: worlds as pictures, drawn on this machine's processor, with no browser and no screen.

It follows what three.js does with the same meshes, light and air (Lambert's law, the ACES filmic
curve, fog over what is shown), without its faint highlights, and smooths edges by drawing finer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import not_found
from evastudio.studio.air import HORIZON_MOVES, backdrop, horizon
from evastudio.studio.brush import finished, paint
from evastudio.studio.node import checked
from evastudio.studio.view import checked_camera
from evastudio.world.bodies import FIELD_OF_VIEW, Camera, Mesh
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

FINE = 2
"""Points drawn across and down for each of the picture."""


@dataclass(frozen=True)
class _Shape:
    """A mesh as the brush takes it."""

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    mesh: Mesh


class Painter:
    """Paints worlds of one scene, all pictures of one size."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        """Pictures are `width` by `height` points."""
        self._scene = scene
        self._shapes = {name: _shape(mesh) for name, mesh in scene.meshes().items()}
        look = scene.look
        sun = np.asarray(look.sun_direction, dtype=np.float64)
        self._light = np.stack(
            [
                sun / np.linalg.norm(sun),
                look.sun * _linear(look.sun_color),
                look.sky * _linear(look.sky_color),
                look.sky * _linear(look.ground_color),
            ]
        )
        self._air = np.array(
            [*(part / 255 for part in look.background), look.fog_near, look.fog_far]
        )
        self._canvas = np.empty((height * FINE, width * FINE, 3), dtype=np.float32)
        self._depths = np.empty((height * FINE, width * FINE), dtype=np.float32)
        self._behind: tuple[float, NDArray[np.float32]] = (-1.0, np.empty(0, dtype=np.float32))
        self._picture = np.empty((height, width, 3), dtype=np.uint8)

    def paint(self, snapshot: Snapshot, camera: Camera) -> NDArray[np.uint8]:
        """The first world of `snapshot` seen from `camera`; shape (height, width, 3), sRGB.

        The same array each time. Raises InvalidInputError for numbers that cannot be drawn.
        """
        position, look_at, up = checked_camera(camera)
        ahead = np.subtract(look_at, position)
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, up)
        right /= np.linalg.norm(right)
        seen_from = np.stack([right, np.cross(ahead, right), ahead, np.asarray(position)])
        focal = len(self._canvas) / 2 / np.tan(FIELD_OF_VIEW / 2)
        np.copyto(self._canvas, self._sky(horizon(position, look_at)))
        self._depths[:] = 1.0 / self._air[4]
        bodies = self._scene.bodies(snapshot)
        for body in bodies:
            if body.mesh not in self._shapes:
                kind = f"mesh of scene {self._scene.name!r}"
                raise not_found(kind, body.mesh, self._shapes)
        # What shines through comes last, over what is behind it.
        for body in sorted(bodies, key=lambda body: -self._shapes[body.mesh].mesh.opacity):
            shape, placed = self._shapes[body.mesh], checked(body)
            count = len(placed.positions)
            tint = shape.mesh.color if placed.colors is None else placed.colors
            scales = placed.scales if placed.scales.ndim == 2 else placed.scales[:, None]
            paint(
                shape.vertices,
                shape.normals,
                shape.faces,
                shape.mesh.flat,
                shape.mesh.glow,
                float(shape.mesh.opacity),
                placed.positions.astype(np.float64),
                placed.wxyzs.astype(np.float64),
                np.array(np.broadcast_to(scales, (count, 3)), dtype=np.float64),
                np.array(np.broadcast_to(self._tint(shape.mesh, tint), (count, 3))),
                seen_from,
                focal,
                self._light,
                self._air,
                self._canvas,
                self._depths,
            )
        finished(self._canvas, FINE, self._picture)
        return self._picture

    def _tint(self, mesh: Mesh, color: object) -> Array:
        """As viser's client takes it: what glows as sRGB, all else as amounts of light already."""
        return _linear(color) if mesh.glow else np.asarray(color, dtype=np.float64) / 255

    def _sky(self, at: float) -> NDArray[np.float32]:
        look = self._scene.look
        known, behind = self._behind
        if known < 0.0 or (look.zenith is not None and abs(at - known) > HORIZON_MOVES / 4):
            behind = (backdrop(look, at, self._depths.shape) / np.float32(255)).astype(np.float32)
            self._behind = (at, behind)
        return behind


def _shape(mesh: Mesh) -> _Shape:
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], np.cross(b - a, c - a))
    return _Shape(vertices, normals, faces, mesh)


def _linear(color: object) -> Array:
    """sRGB of 0 to 255 as amounts of light, 0 to 1."""
    share = np.asarray(color, dtype=np.float64) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
