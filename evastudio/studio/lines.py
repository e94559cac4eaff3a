"""A line over a scene as a node of viser's."""

from __future__ import annotations

from typing import Any

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.studio.mounted import MountedViser
from evastudio.world.bodies import Line


def drawn(server: MountedViser, line: Line) -> Any:
    """The node of `line`; its points are joined by segments, coloured from end to end.

    Raises InvalidInputError for numbers that cannot be drawn: one of them would cost viser every
    client.
    """
    points, colors = np.asarray(line.points, dtype=np.float32), line.colors
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InvalidInputError(
            f"The points of line {line.name!r} have shape {points.shape} and must be finite rows "
            "of three numbers."
        )
    if colors.shape != points.shape or colors.dtype != np.uint8:
        raise InvalidInputError(
            f"The colors of line {line.name!r} are {colors.dtype} of shape {colors.shape}; "
            f"expected uint8 of shape {points.shape}."
        )
    return server.scene.add_line_segments(
        f"/lines/{line.name}",
        np.stack([points[:-1], points[1:]], axis=1),
        np.stack([colors[:-1], colors[1:]], axis=1),
        thickness=line.pixels,
        thickness_units="screen",
    )
