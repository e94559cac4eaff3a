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
