"""Light, fog and background of a scene, in viser."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from evastudio.studio.mounted import Point
from evastudio.world.bodies import FIELD_OF_VIEW, Color, Look

BACKDROP = (180, 320)
"""Rows and columns of the backdrop, which the client stretches over the window."""


HORIZON_MOVES = 0.02
"""Shares of the view's height by which the horizon moves before a new backdrop is sent."""


def set_air(server: viser.ViserServer, look: Look) -> None:
    """Light `server`'s scene as `look` says."""
    scene = server.scene
    scene.configure_default_lights(False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky",
        sky_color=look.sky_color,
        ground_color=look.ground_color,
        intensity=look.sky,
    )
    sun = np.asarray(look.sun_direction, dtype=np.float64)
    x, y, z = (float(part) for part in sun / np.linalg.norm(sun) * 1000.0)
    scene.add_light_directional(
        "/light/sun", color=look.sun_color, intensity=look.sun, position=(x, y, z)
    )
    scene.configure_fog(look.fog_near, look.fog_far, color=linear(look.background))
    scene.set_background_image(backdrop(look), format="png")
    server.initial_camera.near = 0.1
    server.initial_camera.far = look.fog_far + 10.0
    server.initial_camera.fov = float(FIELD_OF_VIEW)


def linear(color: Color) -> tuple[float, float, float]:
    """`color` as amounts of light, 0 to 1: what viser takes a fog and glTF an emission to be in."""
    r, g, b = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (channel / 255 for channel in color)
    )
    return r, g, b


def horizon(position: Point, look_at: Point) -> float:
    """Where a camera sees the horizon: share of the view's height from the top, 0 to 1."""
    x, y, z = np.subtract(look_at, position)
    level = np.hypot(x, y)
    if level == 0.0:
        return 0.0 if z < 0.0 else 1.0
    return float(np.clip(0.5 + z / level / np.tan(FIELD_OF_VIEW / 2) / 2, 0.0, 1.0))


def backdrop(
    look: Look, horizon: float = 0.5, size: tuple[int, int] = BACKDROP
) -> NDArray[np.uint8]:
    """What lies behind everything, `size` its rows and columns. Shape (rows, columns, 3).

    A sky down to the `horizon` where `look` has one, else the distance, a little darker towards the
    corners, and less so where it is bright. A little noise keeps it from showing in bands.
    """
    rows, columns = size
    y, x = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    distance = np.asarray(look.background, dtype=np.float64)
    if look.zenith is None:
        corners = 0.4 - 0.34 * float(distance.mean()) / 255.0
        shade = 1.0 - corners * np.clip(np.sqrt(x**2 + y**2) - 0.3, 0.0, 1.0)
        colors = distance * shade[:, :, None]
    else:
        high = np.clip(1.0 - (y + 1.0) / (2.0 * max(horizon, 1e-6)), 0.0, 1.0)[:, :, None]
        colors = distance + (np.asarray(look.zenith) - distance) * (1.0 - (1.0 - high) ** 2)
    noise = np.random.default_rng(0).uniform(0.0, 1.0, (rows, columns, 1))
    return np.floor(colors + noise).clip(0, 255).astype(np.uint8)
