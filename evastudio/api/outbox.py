"""What a page will be told: a slow one misses what the next message tells anyway, nothing else."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Mapping
from typing import Any

WAITING = 64
"""Messages that may wait for a slow page before some are dropped."""
PASSING = ("status", "ack")
"""Types of which the next one tells all that the one before did."""


class Outbox:
    """What one page will be told. Lives on the event loop."""

    def __init__(self) -> None:
        self._waiting: deque[Mapping[str, Any]] = deque()
        self._some = asyncio.Event()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, message: Mapping[str, Any]) -> None:
        """Tell it next; where too much waits the oldest that passes is dropped, or the oldest."""
        if len(self._waiting) >= WAITING:
            passing = (n for n, one in enumerate(self._waiting) if one["type"] in PASSING)
            del self._waiting[next(passing, 0)]
        self._waiting.append(message)
        self._some.set()

    async def get(self) -> Mapping[str, Any]:
        """The next one."""
        while not self._waiting:
            self._some.clear()
            await self._some.wait()
        return self._waiting.popleft()


class Post:
    """Brings what threads tell into outboxes. The event loop is woken once for all that it has not
    fetched yet, not for each message of each stage."""

    def __init__(self) -> None:
        """For the event loop that runs."""
        self._loop = asyncio.get_running_loop()
        self._letters: deque[tuple[Outbox, Mapping[str, Any]]] = deque()
        self._rung = False

    def tell(self, out: Outbox, message: Mapping[str, Any]) -> None:
        """Put `message` into `out` soon; from any thread."""
        self._letters.append((out, message))
        if not self._rung:  # what comes in between is fetched too, for the loop asks after that
            self._rung = True
            self._loop.call_soon_threadsafe(self._fetch)

    def _fetch(self) -> None:
        self._rung = False
        while self._letters:
            out, message = self._letters.popleft()
            out.put(message)
