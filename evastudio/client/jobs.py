"""Jobs: work that a studio does in a process of its own, followed until it ends."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import httpx

from evastudio.client.connection import TRIES, Connection, refusal
from evastudio.client.reading import read
from evastudio.errors import JobError

SILENCE_S = 60.0
"""A stream of events that is silent for longer is lost: the studio says now and then it is there.
"""
ENDED = frozenset({"done", "failed", "cancelled"})


@dataclass(frozen=True)
class Job:
    """A job as it stood when it was told."""

    id: int
    kind: str
    session: int | None
    state: str
    """'queued', 'running', 'done', 'failed' or 'cancelled'."""
    progress: float
    """0 to 1."""
    message: str
    """What it is doing, for people."""
    result: Mapping[str, Any] | None
    """Of one that is done."""
    error: str | None
    """Why one failed."""

    @property
    def ended(self) -> bool:
        """Whether it is done, failed or cancelled."""
        return self.state in ENDED


class Jobs:
    """`studio.jobs`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Job]:
        """Jobs since the studio started, newest first."""
        return (read(Job, told) for told in self._connection.pages("/jobs"))

    def get(self, job: int) -> Job:
        """How a job stands. Raises NotFoundError."""
        return read(Job, self._connection.get(f"/jobs/{job}"))

    def cancel(self, job: int) -> Job:
        """End a job that waits or runs."""
        return read(Job, self._connection.delete(f"/jobs/{job}"))

    def again(self, job: int) -> Job:
        """Run an ended job once more; the new one. Raises ConflictError where it has not ended."""
        return read(Job, self._connection.post(f"/jobs/{job}/again"))

    def wait(self, job: Job | int, progress: Callable[[Job], None] = lambda job: None) -> Job:
        """The job once it is done; `progress` is called with it whenever it has gone on.

        Raises JobError, saying why, where it failed or was cancelled.
        """
        number = job if isinstance(job, int) else job.id
        last = None
        for last in self.follow(number):
            progress(last)
        if last is None or not last.ended:
            last = self.get(number)
        if last.state != "done":
            raise JobError(last.error or f"Job {number} ({last.kind}) is {last.state}.")
        return last

    def follow(self, job: int | None = None) -> Iterator[Job]:
        """A job whenever it has changed, until its end; without one, all jobs, for ever.

        A connection that is lost is taken up where it was. Raises NotFoundError, and
        UnreachableError where the studio does not answer any more.
        """
        path = "/jobs/events" if job is None else f"/jobs/{job}/events"
        last, lost = "", 0
        while True:
            headers = {"Last-Event-ID": last} if last else {}
            try:
                with self._connection.stream(path, headers, SILENCE_S) as answer:
                    if answer.is_error:
                        answer.read()
                        raise refusal(answer)
                    for number, told in _events(answer):
                        last, lost = number, 0
                        yield read(Job, told)
                    return  # the job has ended, or the studio stops
            except httpx.TransportError as error:
                lost += 1
                if lost == TRIES:
                    raise self._connection.lost(error) from None


def _events(answer: httpx.Response) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Id and content of server-sent events."""
    fields: dict[str, str] = {}
    for line in answer.iter_lines():
        name, _, value = line.partition(": ")
        if line and name:
            fields[name] = value
        elif not line and "data" in fields:
            yield fields.get("id", ""), json.loads(fields["data"])
            fields = {}
