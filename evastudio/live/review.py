"""Looking back at a run: where in it, and how fast it goes on."""

from __future__ import annotations

from evastudio.errors import InvalidInputError
from evastudio.live.reel import Reel
from evastudio.world.snapshot import Snapshot

SPEEDS = (-8.0, 8.0)
"""How fast one looks back at a run, to its beginning and to its end."""


class Review:
    """A place in a reel that moves with time, or stands. `now` is a monotonic clock's."""

    def __init__(self, reel: Reel, at: float, now: float) -> None:
        """At step `at` of `reel`, or between two; it stands."""
        self.reel = reel
        self.speed = 0.0
        self.position = 0.0
        """In steps."""
        self.seek(at, now)

    @property
    def step(self) -> int:
        return int(self.position)

    @property
    def seconds(self) -> float:
        """Since the run began."""
        return self.position * self.reel.scene.dt_s

    @property
    def picture(self) -> Snapshot:
        """What is seen there."""
        return self.reel.shown(self.position)

    def seek(self, at: float, now: float) -> None:
        """Look at step `at`, or between two, or the nearest that is remembered."""
        self.position = min(max(at, float(self.reel.first)), float(self.reel.last))
        self._at = now

    def roll(self, speed: float, now: float) -> None:
        """Go on at `speed`, 1 as it happened; 0 stands, below 0 goes back.

        Raises InvalidInputError outside of `SPEEDS`.
        """
        if not SPEEDS[0] <= speed <= SPEEDS[1]:
            raise InvalidInputError(
                f"The speed is {speed:g}; it must be from {SPEEDS[0]:g} to {SPEEDS[1]:g}."
            )
        self.speed, self._at = speed, now

    def advance(self, now: float) -> None:
        """Move on; it stands where the run ends."""
        if self.speed:
            self.seek(self.position + self.speed * (now - self._at) / self.reel.scene.dt_s, now)
            if self.position == (self.reel.first if self.speed < 0.0 else self.reel.last):
                self.speed = 0.0
