"""When each decision of a stage is due, how late it began, and how fast its time goes."""

from __future__ import annotations

from collections.abc import Iterator

from evastudio.errors import InvalidInputError
from evastudio.live.tally import Tally

PACES = (0.25, 1.0)
"""The slowest that a world's time goes, and the fastest, which is real time."""
LATE_SHARE = 0.5
"""A step that begins more than this share of a step after its time is late."""
STALL_S = 1.0
"""After a longer standstill (a laptop that slept) the clock is set on instead of caught up."""


class Clock:
    """Decisions every `dt_s` seconds of a world's time, without drift against the real one.

    Reads no clock itself: `now` is seconds of a monotonic one.
    """

    def __init__(self, dt_s: float, now: float) -> None:
        self.dt_s = dt_s
        self.pace = 1.0
        """Seconds of the world's time in one of the real time."""
        self.due = now
        """When the next decision falls, real time."""
        self.tally = Tally()
        self.drift_s = 0.0
        """How far the latest step began after its time."""
        self._due = now

    @property
    def steps(self) -> int:
        return self.tally.steps

    @property
    def late_steps(self) -> int:
        return self.tally.late_steps

    @property
    def interval(self) -> tuple[float, float]:
        """The time of the world that the next decision acts on."""
        return self._due - self.dt_s, self._due

    def world_time(self, now: float) -> float:
        """The world's time at `now`; it goes on while nothing is decided."""
        return self._due - (self.due - now) * self.pace

    def share(self, now: float) -> float:
        """How much of the step before the next decision has passed, 0 to 1."""
        return min(max(1.0 - (self.due - now) * self.pace / self.dt_s, 0.0), 1.0)

    def start(self, now: float) -> None:
        """The next decision falls one step from `now`: a step acts on the time before it."""
        self._due = self.world_time(now) + self.dt_s
        self.due = now + self.dt_s / self.pace

    def keep_pace(self, pace: float, now: float) -> None:
        """Let the world's time go `pace` times as fast from `now` on; what is recorded is in its
        own time. Raises InvalidInputError outside of `PACES`."""
        if not PACES[0] <= pace <= PACES[1]:
            raise InvalidInputError(
                f"The pace is {pace:g}; it must be from {PACES[0]:g} to {PACES[1]:g}."
            )
        self.due = now + (self.due - now) * self.pace / pace
        self.pace = pace

    def due_steps(self, now: float) -> Iterator[None]:
        """Once for each decision that is due at `now`, which is done before the next is asked for.

        Whoever stops asking stops the clock where it is.
        """
        if now - self.due > STALL_S:
            self.tally.late_steps += int((now - self.due) * self.pace / self.dt_s)
            self.start(now)
        while now >= self.due:
            self.drift_s = now - self.due
            self.tally.note(self.drift_s)
            self.tally.late_steps += self.drift_s * self.pace > LATE_SHARE * self.dt_s
            yield
            self.due += self.dt_s / self.pace
            self._due += self.dt_s
