"""Connections: what is being answered now, for whom; counted, and cut when a token is revoked."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass

from evastudio.api import limits
from evastudio.api.people import Person
from evastudio.errors import StudioError

LOOK_S = 2.0
"""Between two looks at which tokens are still good."""


@dataclass(eq=False)
class Connection:
    """One request or websocket, while it is answered."""

    person: Person
    socket: bool
    task: asyncio.Task[object]
    cut: bool = False
    """Whether it was ended because its token is no longer good."""


class Connections:
    """Everything that is being answered. Lives on the event loop."""

    def __init__(self, good: Callable[[], Awaitable[set[int]]]) -> None:
        """`good` tells the ids of the named tokens that are good now."""
        self._good = good
        self._open: set[Connection] = set()
        self._looking: asyncio.Task[None] | None = None

    def full(self, person: Person, socket: bool) -> tuple[int, str] | None:
        """Status and sentence where no more can be taken on for `person` now, or None."""
        alike = [one for one in self._open if one.socket is socket]
        each, most = (
            (limits.SOCKETS_EACH, limits.SOCKETS_ALL)
            if socket
            else (limits.REQUESTS_EACH, limits.REQUESTS_ALL)
        )
        if len(alike) >= most:
            return 503, "The studio answers as much as it can at once. Try again in a moment."
        if sum(one.person == person for one in alike) >= each:
            what = "connections" if socket else "requests"
            told = f"{each} {what} with this token are open at once; let some of them end first."
            return 429, told
        return None

    @contextlib.contextmanager
    def answering(self, person: Person, socket: bool) -> Iterator[Connection]:
        """Count the current task as one that answers `person`, within the block."""
        task = asyncio.current_task()
        assert task is not None
        connection = Connection(person, socket, task)
        self._open.add(connection)
        if person.token is not None and self._looking is None:
            self._looking = asyncio.get_running_loop().create_task(self._look())
        try:
            yield connection
        finally:
            self._open.discard(connection)

    async def _look(self) -> None:
        """Cut whoever's token was revoked, for as long as somebody with a named one is here."""
        try:
            while named := {one for one in self._open if one.person.token is not None}:
                with contextlib.suppress(StudioError):  # the store cannot be asked now
                    good = await self._good()
                    for one in named & self._open:
                        if one.person.token not in good:
                            one.cut = True
                            one.task.cancel()
                await asyncio.sleep(LOOK_S)
        finally:
            self._looking = None
