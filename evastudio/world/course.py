"""A course: what a planner must know of a scene to search it without flying it."""

from __future__ import annotations

from dataclasses import dataclass

from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Course:
    """Steady flight among balls to a far plane, x = `length`.

    A decision adds its two angles to yaw and pitch, which stay within `steepest`, and the point
    flies on for one decision step. It is lost where it comes nearer than `reach` to the middle of
    a ball, or farther than `half_width` to the side.
    """

    balls: Array
    """Their middles, shape (worlds, N, 3), metres."""
    reach: float
    """Metres from the middle of a ball at which the point touches it."""
    position: Array
    """Of the point, shape (worlds, 3), metres."""
    heading: Array
    """Yaw and pitch, shape (worlds, 2), rad."""
    speed: float
    """Metres a second."""
    steepest: float
    """Largest yaw and pitch, rad."""
    length: float
    """Where the far plane is, metres."""
    half_width: float
    """Metres from the middle at which the corridor ends, to each side."""
