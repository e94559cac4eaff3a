"""Takes one after another: a rest, another world, a countdown, until as many are kept as wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from evastudio.errors import InvalidInputError
from evastudio.live.status import Phase

LONGEST_REST_S = 60.0
MOST = 10_000


@dataclass(frozen=True)
class Arrangement:
    """What an animator wants of takes. Raises InvalidInputError out of its bounds."""

    wanted: int | None = None
    """How many takes of the session; None where that was not said."""
    automatic: bool = False
    """Whether the next take begins by itself."""
    rest_s: float = 3.0
    """Between the end of a take and the countdown of the next."""

    def __post_init__(self) -> None:
        if self.wanted is not None and not 1 <= self.wanted <= MOST:
            raise InvalidInputError(f"{self.wanted} takes are wanted; it must be 1 to {MOST:,}.")
        if not 0.0 <= self.rest_s <= LONGEST_REST_S:
            raise InvalidInputError(
                f"The rest is {self.rest_s:g} s; it must be from 0 to {LONGEST_REST_S:g} s."
            )


class Series:
    """When the next take begins by itself. Reads no clock: `now` is seconds of a monotonic one."""

    def __init__(self) -> None:
        self.arrangement = Arrangement()
        self.next_at: float | None = None
        """When the next take begins; None where none does by itself."""
        self._again: Callable[[], None] | None = None

    def arrange(self, arrangement: Arrangement) -> None:
        """From now on it goes like that; a rest that has begun lasts as it was."""
        self.arrangement = arrangement
        if not arrangement.automatic:
            self.next_at = None

    def begun(self, again: Callable[[], None]) -> None:
        """A person began a take; `again` begins another."""
        self._again, self.next_at = again, None

    def halt(self) -> None:
        """No take begins by itself until a person begins one."""
        self._again = self.next_at = None

    def beat(self, phase: Phase, kept: int | None, now: float) -> None:
        """Begin the next take where it is due.

        Takes rest after they ended, or were thrown away. `kept` is how many the session has, None
        where that is being counted.
        """
        wanted = self.arrangement.wanted
        resting = phase in (Phase.ENDED, Phase.READY) and self.arrangement.automatic
        if self._again is None or not resting:
            self.next_at = None
        elif wanted is not None and kept is not None and kept >= wanted:
            self.halt()
        elif self.next_at is None:
            self.next_at = now + self.arrangement.rest_s
        elif now >= self.next_at and kept is not None:
            self.next_at = None
            self._again()

    def told(self, now: float) -> dict[str, Any]:
        """What a page shows of it."""
        left = None if self.next_at is None else max(0.0, self.next_at - now)
        return {**vars(self.arrangement), "next_s": left}
