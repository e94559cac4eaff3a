"""Light, fog and background of a scene, in viser."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from evastudio.world.bodies import FIELD_OF_VIEW, Color, Look

BACKDROP = (180, 320)
"""Rows and columns of the backdrop, which the client stretches over the window."""


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
    scene.set_background_image(backdrop(look.background), format="png")
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


def backdrop(color: Color) -> NDArray[np.uint8]:
    """The distance, a little darker towards the corners. Shape (rows, columns, 3)."""
    rows, columns = BACKDROP
    y, x = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    shade = 1.0 - 0.4 * np.clip(np.sqrt(x**2 + y**2) - 0.3, 0.0, 1.0)
    noise = np.random.default_rng(0).uniform(0.0, 1.0, (rows, columns, 1))
    colors = np.asarray(color, dtype=np.float64) * shade[:, :, None]
    return np.floor(colors + noise).clip(0, 255).astype(np.uint8)
