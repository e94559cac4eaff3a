"""What a stage gives to whoever draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from evastudio.world.bodies import Camera, Line
from evastudio.world.snapshot import Snapshot


@dataclass(frozen=True)
class Picture:
    """One frame."""

    snapshot: Snapshot
    """The first of its worlds is drawn."""
    fresh: bool
    """Whether its world is another than that of the picture before."""
    camera: Camera
    lines: tuple[Line, ...] = ()
    """What is drawn over it; the same object as before where it has not changed."""


Show = Callable[[Picture], None]
