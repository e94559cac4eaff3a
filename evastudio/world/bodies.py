"""What a scene looks like, as data: meshes, instances, light and camera. Nothing here draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.world.spaces import Array

Color = tuple[int, int, int]


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh that many bodies can share."""

    vertices: Array
    """Shape (V, 3), metres, in the body's frame: x forward, y left, z up."""
    faces: NDArray[np.int64]
    """Shape (F, 3), indices into `vertices`, counter-clockwise seen from outside."""
    color: Color
    """sRGB, 0 to 255."""
    flat: bool = False
    """Facets are shown as they are instead of smoothed."""
    glow: bool = False
    """Drawn at full brightness, not lit: an engine flame, a marker."""
    opacity: float = 1.0
    """Below 1 what is behind shines through: a shadow on the ground. Not for one that glows."""


@dataclass(frozen=True)
class Body:
    """Instances of one mesh."""

    name: str
    """Unique among the bodies of a scene; the same body keeps its name from frame to frame."""
    mesh: str
    """A key of the scene's `meshes`."""
    positions: Array | NDArray[np.float32]
    """Shape (N, 3), metres, world frame."""
    wxyzs: Array | NDArray[np.float32]
    """Shape (N, 4), unit quaternions from the body's frame to the world's."""
    scales: Array | NDArray[np.float32]
    """Shape (N,), 1 = the mesh as it is; or (N, 3), along x, y and z of the body's frame."""
    fixed: bool = False
    """Never moves during a take: drawn once."""
    colors: NDArray[np.uint8] | None = None
    """Shape (N, 3), sRGB, in place of the mesh's colour; not for a mesh that glows."""


@dataclass(frozen=True)
class Line:
    """A way drawn into a world: from point to point, as wide on the screen wherever it is."""

    name: str
    """Unique among the lines of a picture."""
    points: NDArray[np.float32]
    """Shape (N, 3), metres."""
    colors: NDArray[np.uint8]
    """Shape (N, 3), sRGB, of each point."""
    pixels: float = 3.0
    """How wide."""


FIELD_OF_VIEW = np.radians(60.0)
"""Of every view, from its lower to its upper edge."""


@dataclass(frozen=True)
class Camera:
    """Where a view is seen from."""

    position: Array
    """Shape (3,), metres."""
    look_at: Array
    """Shape (3,), metres."""
    up: Array
    """Shape (3,), unit."""


@dataclass(frozen=True)
class Look:
    """Light and air of a scene."""

    background: Color
    """Colour of the far distance and of the fog."""
    fog_near: float
    """Metres at which the fog begins."""
    fog_far: float
    """Metres at which nothing else is seen."""
    sun_direction: tuple[float, float, float]
    """From the world towards the sun."""
    sun: float = 3.0
    sky: float = 1.2
    sky_color: Color = (160, 190, 255)
    ground_color: Color = (40, 34, 46)
    sun_color: Color = (255, 240, 220)
    zenith: Color | None = None
    """Colour of the sky, which pales towards the background's at the horizon; None where the
    distance is the same all around."""
