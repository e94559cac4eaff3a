"""One body of a scene as a node of viser's."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.studio.air import linear
from evastudio.studio.mounted import MountedViser
from evastudio.world.bodies import Body, Mesh

Numbers = NDArray[np.float32]
FINE = 100
"""Triangles from which on a mesh that many bodies share has a coarser form."""
FAR = 9.0
"""Radii from the camera at which that form is shown."""


@dataclass(frozen=True)
class Instances:
    """The arrays of a body, as they are sent."""

    positions: Numbers
    """Shape (N, 3)."""
    wxyzs: Numbers
    """Shape (N, 4)."""
    scales: Numbers
    """Shape (N,) or (N, 3)."""
    colors: NDArray[np.uint8] | None
    """Shape (N, 3), or None where all have their mesh's."""


def checked(body: Body) -> Instances:
    """The instances of `body`, all finite and as many of each kind.

    One value that cannot be sent would cost viser every client, so nothing unchecked gets there.
    """
    count = len(body.positions)
    each = ((count, 3),) if np.ndim(body.scales) == 2 else ((count,),)
    shapes = ((count, 3), (count, 4), *each)
    arrays = []
    for name, shape in zip(("positions", "wxyzs", "scales"), shapes, strict=True):
        array = np.asarray(getattr(body, name), dtype=np.float32)
        if array.shape != shape:
            raise InvalidInputError(
                f"The {name} of body {body.name!r} have shape {array.shape}; expected {shape}."
            )
        if not np.isfinite(array).all():
            raise InvalidInputError(
                f"The {name} of body {body.name!r} hold NaN or infinite numbers; a view can only "
                "draw finite ones."
            )
        arrays.append(array)
    colors = body.colors
    if colors is not None and (colors.shape != (count, 3) or colors.dtype != np.uint8):
        raise InvalidInputError(
            f"The colors of body {body.name!r} are {colors.dtype} of shape {colors.shape}; "
            f"expected uint8 of shape {(count, 3)}."
        )
    return Instances(arrays[0], arrays[1], arrays[2], colors)


class Node:
    """Draws one body, with as few messages as its changes need.

    A single body moves as its node's pose, which the client applies without building anything
    anew; many are instances of one batched mesh.
    """

    def __init__(self, server: MountedViser, name: str, mesh: Mesh) -> None:
        self._server = server
        self._name = f"/bodies/{name}"
        self._mesh = mesh
        self._handle: Any = None
        self._count = 0
        self._dimensions = 1
        self._pose: tuple[list[float], list[float]] | None = None

    def draw(self, body: Instances) -> None:
        """Show the instances, given as `checked` returns them; what stands still costs nothing."""
        count, shape = len(body.positions), body.scales.ndim
        if count != self._count or shape != self._dimensions:
            self.remove()
            self._count, self._dimensions = count, shape
            if count:
                self._handle = self._add(body)
        elif count == 1:
            pose = (body.positions[0].tolist(), body.wxyzs[0].tolist())
            if pose != self._pose:
                self._server.set_pose(self._name, *pose)
                self._pose = pose
            self._vary(body)
        elif count:
            self._handle.batched_positions = body.positions
            self._handle.batched_wxyzs = body.wxyzs
            self._vary(body)

    def _vary(self, body: Instances) -> None:
        """Sizes and colours, which viser sends where they are others than before."""
        self._handle.batched_scales = body.scales
        if body.colors is not None:
            self._handle.batched_colors = body.colors

    def remove(self) -> None:
        """Take the body out of the view."""
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self._count = 0
        self._pose = None

    def _add(self, body: Instances) -> Any:
        positions, wxyzs, scales = body.positions, body.wxyzs, body.scales
        place: dict[str, Any] = {
            "batched_positions": positions,
            "batched_wxyzs": wxyzs,
            "batched_scales": scales,
            "cast_shadow": False,
            "receive_shadow": False,
        }
        if len(positions) == 1:
            place["position"], place["wxyz"] = positions[0], wxyzs[0]
            place["batched_positions"] = np.zeros((1, 3), dtype=np.float32)
            place["batched_wxyzs"] = np.array([[1, 0, 0, 0]], dtype=np.float32)
        mesh = self._mesh
        if mesh.glow:
            return self._server.scene.add_batched_glb(self._name, glowing(mesh), lod="off", **place)
        return self._server.scene.add_batched_meshes_simple(
            self._name,
            mesh.vertices.astype(np.float32),
            mesh.faces.astype(np.uint32),
            batched_colors=mesh.color if body.colors is None else body.colors,
            flat_shading=mesh.flat,
            opacity=None if mesh.opacity >= 1.0 else mesh.opacity,
            lod=self._levels(scales),
            **place,
        )

    def _levels(self, scales: Numbers) -> Any:
        """Half the triangles for instances so far away that nobody sees the difference."""
        if len(scales) == 1 or len(self._mesh.faces) < FINE:
            return "off"
        radius = float(np.linalg.norm(self._mesh.vertices, axis=1).max() * scales.max())
        return ((FAR * radius, 0.4),)


def glowing(mesh: Mesh) -> bytes:
    """A binary glTF file of `mesh`, which shines by itself: viser has no unlit mesh of its own."""
    visual: Any = trimesh.visual
    material = visual.material.PBRMaterial(
        baseColorFactor=[0, 0, 0, 255],
        emissiveFactor=linear(mesh.color),
        metallicFactor=0,
        roughnessFactor=1,
    )
    shape = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    shape.visual = visual.TextureVisuals(material=material)
    file = io.BytesIO()
    shape.export(file, file_type="glb")
    return file.getvalue()
