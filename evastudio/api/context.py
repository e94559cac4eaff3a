"""What every route may use."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Annotated, Any, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from evastudio.api.attendance import Attendance
from evastudio.api.job_feed import JobFeed
from evastudio.api.outbox import Outbox, Post
from evastudio.demonstrations.store import Store
from evastudio.live.jobs import Job, Jobs, Work
from evastudio.live.lineups import Lineups
from evastudio.live.reviewing import Reviewing
from evastudio.live.shelf import Shelf
from evastudio.live.stages import Stages
from evastudio.live.worlds import Worlds
from evastudio.workspace import Workspace


@dataclass
class Context:
    """The parts of a running studio. Hooks are called on the event loop."""

    workspace: Workspace
    store: Store
    jobs: Jobs
    stages: Stages
    film: Work
    """The job that makes footage into a file, which takes a screen to know."""
    stage_closed: list[Callable[[str], None]] = field(default_factory=list)
    job_listeners: set[Callable[[Job], None]] = field(default_factory=set)
    outgoing: set[Outbox] = field(default_factory=set)
    """What waits to be sent to each page."""
    attendances: dict[str, Attendance] = field(default_factory=dict)
    """By the stage's name."""
    shelf: Shelf = field(init=False)
    """The policies, as a program asks them."""
    worlds: Worlds = field(init=False)
    lineups: Lineups = field(init=False)
    reviewing: Reviewing = field(init=False)
    job_feed: JobFeed = field(init=False)
    post: Post = field(init=False)
    _tasks: set[asyncio.Task[None]] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.shelf = Shelf(self.workspace)
        self.worlds = Worlds(self.workspace, self.store)
        self.lineups = Lineups(self.workspace, self.store)
        self.reviewing = Reviewing(self.workspace, self.store)
        self.post = Post()
        self.job_feed = JobFeed(self.jobs.all)
        self.job_listeners.add(self.job_feed.tell)

    @property
    def messages_waiting(self) -> int:
        """How many messages wait to be sent to pages."""
        return sum(len(box) for box in self.outgoing)

    def background(self, work: Coroutine[Any, Any, None]) -> None:
        """Run `work` on the event loop, and keep it alive until it is done."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


async def _context(connection: HTTPConnection) -> Context:
    return cast("Context", connection.app.state.context)


Studio = Annotated[Context, Depends(_context)]
"""What a route declares to get the context."""
