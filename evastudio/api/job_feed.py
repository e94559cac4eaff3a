"""The feed of jobs: who listens is told every change, as server-sent events.

https://html.spec.whatwg.org/multipage/server-sent-events.html
"""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import AsyncIterator, Callable, Iterable

from evastudio.api.arrays import as_json
from evastudio.errors import ConflictError
from evastudio.live.jobs import ENDED, Job

HEARTBEAT_S = 15.0
"""A comment is sent after so long a silence, so that nobody takes it for a lost connection."""
MOST_LISTENERS = 200


class JobFeed:
    """What has changed among jobs, in order. Lives on the event loop.

    Of each job the latest state alone is kept, and each listener remembers how far it has read:
    however slow one is, it costs nothing, and misses no end.
    """

    def __init__(self, known: Callable[[], Iterable[Job]]) -> None:
        """`known` tells the jobs that are remembered; others are forgotten here too."""
        self._known = known
        self._run = secrets.token_hex(4)
        self._number = 0
        self._changes: dict[int, tuple[int, Job]] = {}
        self._news = asyncio.Event()
        self._listeners = 0
        self._closed = False

    def tell(self, job: Job) -> None:
        """A job has changed."""
        self._number += 1
        self._changes.pop(job.id, None)
        self._changes[job.id] = self._number, job
        known = {one.id for one in self._known()}
        for forgotten in [number for number in self._changes if number not in known]:
            del self._changes[forgotten]
        self._wake()

    def close(self) -> None:
        """End every stream: the studio stops."""
        self._closed = True
        self._wake()

    def is_over(self, job: Job, last_seen: str | None) -> bool:
        """Whether a listener that was told `last_seen` already knows how `job` ended."""
        return job.state in ENDED and not self._after(self._place(last_seen), job.id)

    def listen(self, last_seen: str | None = None, only: int | None = None) -> AsyncIterator[str]:
        """What changes from now on, as events; at first how the jobs stand, or what has changed
        since the event `last_seen`.

        Of one job `only` until it has ended. Raises ConflictError where too many listen.
        """
        if self._listeners >= MOST_LISTENERS:
            raise ConflictError(
                f"{MOST_LISTENERS} programs follow the jobs already; close one, or ask for the "
                "job now and then."
            )
        return self._listen(self._place(last_seen), only)

    async def _listen(self, place: int, only: int | None) -> AsyncIterator[str]:
        self._listeners += 1
        try:
            while not self._closed:
                news = self._news
                for number, job in self._after(place, only):
                    place = number
                    yield self._event(number, job)
                    if only is not None and job.state in ENDED:
                        return
                if news is self._news and not await _within(HEARTBEAT_S, news):
                    yield ": still here\n\n"
        finally:
            self._listeners -= 1

    def _place(self, last_seen: str | None) -> int:
        """How far a listener has read; nothing where that was told by another run."""
        run, _, number = (last_seen or "").partition("-")
        return int(number) if run == self._run and number.isdecimal() else 0

    def _after(self, place: int, only: int | None) -> list[tuple[int, Job]]:
        """Changes after `place`, in order; of one job where it is `only` that."""
        found = self._changes.values() if only is None else [self._changes.get(only)]
        return [one for one in found if one is not None and one[0] > place]

    def _event(self, number: int, job: Job) -> str:
        name = "end" if job.state in ENDED else "change"
        told = as_json(job.to_json()).decode()
        return f"id: {self._run}-{number}\nevent: {name}\ndata: {told}\n\n"

    def _wake(self) -> None:
        news, self._news = self._news, asyncio.Event()
        news.set()


async def _within(seconds: float, news: asyncio.Event) -> bool:
    """Whether there are `news` by then."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await news.wait()
    return news.is_set()
