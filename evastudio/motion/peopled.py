"""Scenes that people walk in: how these move is not the scene's, but the workspace's to choose."""

from __future__ import annotations

from evastudio.motion.figures import Figures, figures
from evastudio.world.scene import Scene


class Peopled(Scene):
    """A scene that draws `figures`. Whoever makes it may set other ones; drawing alone uses them.

    What a `step` needs of walking it takes from the shipped figures, so that a take replays
    whatever clips a workspace has.
    """

    _figures: Figures | None = None

    @property
    def figures(self) -> Figures:
        """The bodies that people have; as shipped until others are set."""
        return figures() if self._figures is None else self._figures

    @figures.setter
    def figures(self, chosen: Figures) -> None:
        self._figures = chosen
