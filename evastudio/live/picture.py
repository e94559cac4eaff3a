"""What a stage gives to whoever draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from evastudio.world.bodies import Camera, Line
from evastudio.world.scene import Scene
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


class Shown(Protocol):
    """What can be looked at: a stage, or a column of a lineup."""

    name: str

    @property
    def scene(self) -> Scene: ...

    def watch(self, show: Show) -> None:
        """Call `show` with what to draw, until `unwatch`; the present frame is drawn at once."""

    def unwatch(self, show: Show) -> None:
        """Call `show` no more; does not wait."""
