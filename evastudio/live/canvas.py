"""A canvas: what of a stage is drawn, when, and the lines that are drawn over it."""

from __future__ import annotations

import math

from evastudio.live.picture import Picture, Show
from evastudio.live.run import Run
from evastudio.live.sight import Sight
from evastudio.live.sketch import Led, Trail
from evastudio.world.bodies import Line
from evastudio.world.snapshot import Snapshot

BEHIND_S = 0.003
"""So long after a decision comes the frame that first shows what it led to: one at the very moment
would show the world as it was, and the next come a whole frame later."""


class Canvas:
    """Frames for whoever looks, at the scene's render rate; while nobody does there are none."""

    def __init__(self, now: float) -> None:
        self.on_frame: list[Show] = []
        self.sight = Sight()
        self._trail = Trail()
        self._led = Led()
        self._over: tuple[int, tuple[Line, ...]] | None = None
        self._fresh = True
        self._next = now

    @property
    def due(self) -> float:
        """When the next frame is; infinite while nobody looks."""
        return self._next if self.on_frame else math.inf

    def soon(self) -> None:
        """What is to be seen has changed."""
        self._next = 0.0

    def decided(self, at: float) -> None:
        """A decision fell at `at`: frames follow it, instead of at a phase of their own."""
        self._next = at + BEHIND_S

    def clear(self) -> None:
        """Another world is drawn from now on."""
        self.sight.forget()
        self._fresh = True
        self._over = None

    def sketch(self, step: int, lines: tuple[Line, ...]) -> None:
        """Draw `lines` over the moment `step`, for as long as one looks at it."""
        self._over = step, lines
        self.soon()

    def draw(self, now: float, run: Run, snapshot: Snapshot, lines: tuple[Line, ...]) -> None:
        """The frame that is due at `now`: `snapshot`, which is of `run` or between two of it."""
        self._next += 1.0 / run.scene.render_hz
        if self._next <= now:
            self._next = now + 1.0 / run.scene.render_hz
        camera = self.sight.draw(run.scene, snapshot)
        picture = Picture(snapshot, self._fresh, camera, lines)
        for show in self.on_frame:
            show(picture)
        self._fresh = False

    def lines(self, run: Run, reasons: bool) -> tuple[Line, ...]:
        """The way it came; and what is drawn over the moment, or with `reasons` the ways that the
        decision there came from."""
        trail = self._trail.drawn(run)
        if self._over is not None and self._over[0] == run.steps:
            return (trail, *self._over[1])
        return (trail, *self._led.drawn(run)) if reasons else (trail,)
