"""A canvas: what of a stage is drawn, when, and the lines that are drawn over it."""

from __future__ import annotations

import logging
import math

from evastudio.live.act import Act
from evastudio.live.picture import Picture, Show
from evastudio.live.review import Review
from evastudio.live.run import Run
from evastudio.live.sight import Sight
from evastudio.live.sketch import Led, Trail
from evastudio.live.status import Mode, Phase
from evastudio.world.bodies import Line

logger = logging.getLogger(__name__)

BEHIND_S = 0.003
"""So long after a decision comes the frame that first shows what it led to: one at the very moment
would show the world as it was, and the next come a whole frame later."""


class Canvas:
    """Frames for whoever looks, at the scene's render rate; while nobody does there are none."""

    def __init__(self, now: float) -> None:
        self.sight = Sight()
        self._trail = Trail()
        self._led = Led()
        self._over: tuple[int, tuple[Line, ...]] | None = None
        self._shows: list[Show] = []
        self._fresh = True
        self._failed = False
        self._next = now

    def watch(self, show: Show) -> None:
        """Call `show` with every frame, from the present one on.

        A frame that it cannot draw is dropped: nobody's take ends for it.
        """
        self._shows.append(show)
        self.soon()

    def unwatch(self, show: Show) -> None:
        """Call `show` no more."""
        self._shows.remove(show)

    @property
    def due(self) -> float:
        """When the next frame is; infinite while nobody looks."""
        return self._next if self._shows else math.inf

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

    def draw(self, now: float, act: Act, look_back: Review | None, share: float) -> None:
        """The frame that is due at `now`: of `act`, with `share` of its step behind it, or of what
        is looked back at."""
        self._next += 1.0 / act.run.scene.render_hz
        if self._next <= now:
            self._next = now + 1.0 / act.run.scene.render_hz
        scene, snapshot = act.run.scene, act.run.after
        if act.running:
            snapshot = scene.interpolate(act.run.before, act.run.after, share)
        elif look_back is not None:
            snapshot = look_back.picture
        lines: tuple[Line, ...] = ()
        if act.mode in (Mode.PLAY, Mode.CORRECT, Mode.REVIEW):
            still = act.phase is Phase.PAUSED and act.mode is Mode.PLAY
            lines = self._lines(act.run, reasons=still or look_back is not None)
        picture = Picture(snapshot, self._fresh, self.sight.draw(scene, snapshot), lines)
        for show in self._shows:
            self._show(show, picture)
        self._fresh = False

    def _show(self, show: Show, picture: Picture) -> None:
        try:
            show(picture)
        except Exception:  # scenes say what to draw, and scenes are other people's code
            if not self._failed:
                logger.exception("A frame cannot be drawn")
            self._failed = True

    def _lines(self, run: Run, reasons: bool) -> tuple[Line, ...]:
        """The way it came; and what is drawn over the moment, or with `reasons` the ways that the
        decision there came from."""
        trail = self._trail.drawn(run)
        if self._over is not None and self._over[0] == run.steps:
            return (trail, *self._over[1])
        return (trail, *self._led.drawn(run)) if reasons else (trail,)
