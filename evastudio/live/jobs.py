"""Jobs: work in a process of its own, with progress and cancel, so that no stage stutters."""

from __future__ import annotations

import contextlib
import itertools
import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from evastudio.errors import BusyError, ConflictError, NotFoundError, StudioError
from evastudio.logs import Logs, present, request_id

logger = logging.getLogger(__name__)

Work = Callable[..., dict[str, Any]]
"""A module-level function that takes `progress` beside its own arguments."""
Asked = tuple[str, Work, int | None, dict[str, Any]]
"""What `Jobs.submit` was given."""

MAX_WAITING = 20
NICENESS = 10
"""Added to that of a worker, so that stages go first."""
KEPT = 200
"""Finished jobs are remembered up to this many."""
ASKED = 20
"""And of so many what they were asked, which may be a whole run to be filmed."""


class JobState(StrEnum):
    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


ENDED = (JobState.DONE, JobState.FAILED, JobState.CANCELLED)


@dataclass(frozen=True)
class Job:
    """A job as it stands."""

    id: int
    kind: str
    session: int | None
    state: JobState = JobState.QUEUED
    progress: float = 0.0
    """0 to 1."""
    message: str = "Waiting"
    result: Mapping[str, Any] | None = None
    error: str | None = None
    request: str | None = None
    """Id of the request that asked for it, or None."""

    def to_json(self) -> dict[str, Any]:
        return asdict(self)


class Jobs:
    """Runs jobs one after another, each in a fresh worker process."""

    def __init__(self, on_change: Callable[[Job], None] = lambda job: None) -> None:
        """`on_change` is called, from threads of this object, with every job that changed."""
        self._on_change = on_change
        self._lock = threading.Lock()
        self._jobs: dict[int, Job] = {}
        self._asked: dict[int, Asked] = {}
        self._workers: dict[int, BaseProcess] = {}
        self._numbers = itertools.count(1)
        self._runner = ThreadPoolExecutor(max_workers=1, thread_name_prefix="jobs")

    def submit(self, kind: str, work: Work, session: int | None = None, **arguments: Any) -> Job:
        """Queue `work(progress=..., **arguments)`, with `session` too where one is given.

        Raises BusyError where too many wait.
        """
        with self._lock:
            waiting = sum(job.state is JobState.QUEUED for job in self._jobs.values())
            if waiting >= MAX_WAITING:
                raise BusyError(f"{waiting} jobs wait already; wait for one to end or cancel one.")
            ended = [number for number, job in self._jobs.items() if job.state in ENDED]
            for number in ended[: max(0, len(ended) - ASKED)]:
                self._asked.pop(number, None)
            for number in ended[: max(0, len(ended) - KEPT)]:
                del self._jobs[number]
            job = Job(next(self._numbers), kind, session, request=request_id.get())
            self._jobs[job.id] = job
            self._asked[job.id] = (kind, work, session, dict(arguments))
        self._on_change(job)
        if session is not None:
            arguments["session"] = session
        self._runner.submit(self._run, job.id, work, arguments)
        return job

    def again(self, number: int) -> Job:
        """Queue once more what an ended job was asked to do; the new job.

        Raises NotFoundError, and ConflictError where it has not ended, ended long ago or too many
        wait.
        """
        job = self.get(number)
        if job.state not in ENDED:
            raise ConflictError(
                f"Job {number} has not ended yet; wait for it, or cancel it before it is run again."
            )
        with self._lock:
            asked = self._asked.get(number)
        if asked is None:
            raise ConflictError(
                f"{ASKED} jobs have ended since job {number}, so what it was asked is not known "
                "any more. Ask for it anew."
            )
        kind, work, session, arguments = asked
        return self.submit(kind, work, session, **arguments)

    def get(self, number: int) -> Job:
        """Raises NotFoundError."""
        with self._lock:
            job = self._jobs.get(number)
        if job is None:
            raise _no_job(number)
        return job

    def all(self) -> list[Job]:
        """Every job remembered, newest first."""
        with self._lock:
            return sorted(self._jobs.values(), key=lambda job: -job.id)

    def worker(self, number: int) -> int | None:
        """The process id of a running job's worker, or None."""
        with self._lock:
            worker = self._workers.get(number)
        return None if worker is None else worker.pid

    def cancel(self, number: int) -> Job:
        """End a job that waits or runs; one that has ended stays as it is."""
        job = self.get(number)
        if job.state not in ENDED:
            job = self._change(number, state=JobState.CANCELLED, message="Cancelled")
            with self._lock:
                worker = self._workers.get(number)
            if worker is not None:
                worker.kill()
        return job

    def close(self) -> None:
        """Cancel everything and wait for the workers to be gone."""
        for job in self.all():
            self.cancel(job.id)
        self._runner.shutdown(wait=True)

    def _change(self, number: int, **values: Any) -> Job:
        """Change a job unless it has ended; the job as it then is."""
        with self._lock:
            job = self._jobs[number]
            if job.state in ENDED:
                return job
            job = self._jobs[number] = replace(job, **values)
        self._on_change(job)
        return job

    def _run(self, number: int, work: Work, arguments: dict[str, Any]) -> None:
        if self.get(number).state in ENDED:
            return
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe(duplex=False)
        given = (theirs, work, arguments, present(), self.get(number).request)
        worker = context.Process(target=_work, args=given, daemon=True)
        worker.start()
        theirs.close()
        with self._lock:
            self._workers[number] = worker
        if self._change(number, state=JobState.RUNNING, message="Starting").state in ENDED:
            worker.kill()
        try:
            self._listen(number, ours)
        finally:
            ours.close()
            worker.join()
            with self._lock:
                del self._workers[number]
        self._change(
            number,
            state=JobState.FAILED,
            message="Failed",
            error=_death(worker.exitcode),
        )

    def _listen(self, number: int, ours: Connection) -> None:
        """Follow a worker until it has told its result or is gone."""
        with contextlib.suppress(EOFError, OSError):
            while True:
                told, value = ours.recv()
                if told == "progress":
                    self._change(number, progress=value[0], message=value[1])
                elif told == "result":
                    self._change(
                        number,
                        state=JobState.DONE,
                        progress=1.0,
                        message="Done",
                        result=value,
                    )
                else:
                    self._change(number, state=JobState.FAILED, message="Failed", error=value)


def _no_job(number: int) -> NotFoundError:
    return NotFoundError(f"There is no job {number}; jobs are forgotten at a restart.")


def _death(code: int | None) -> str:
    """Why a worker told no result, from its exit code: minus the signal that ended it."""
    if code is None or code >= 0:
        return f"The work ended before it was done (exit code {code}). Run it again."
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    if -code == signal.SIGKILL:
        return (
            f"The work was killed from outside before it was done ({name}), as a computer does "
            "that runs out of memory. Close other programs, or use fewer takes, and run it again."
        )
    return f"The work broke off before it was done ({name}). Run it again."


def _end_with_parent() -> None:
    """A worker whose server was killed ends too: nobody could be told what comes out."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _give_way() -> None:
    """Let stages go first, whichever thread works.

    On Linux each thread has a niceness of its own, and libraries of linear algebra have started
    theirs by now, as they were loaded.
    """
    os.nice(NICENESS)
    threads = Path("/proc/self/task")
    if threads.is_dir():
        for thread in threads.iterdir():
            os.setpriority(os.PRIO_PROCESS, int(thread.name), os.getpriority(os.PRIO_PROCESS, 0))


def _work(
    pipe: Connection, work: Work, arguments: dict[str, Any], logs: Logs, request: str | None
) -> None:
    """In the worker: run, tell progress, tell the result or why there is none."""
    _give_way()
    logs.begin()
    request_id.set(request)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the server, which ends its jobs
    threading.Thread(target=_end_with_parent, daemon=True).start()

    def progress(share: float, doing: str) -> None:
        pipe.send(("progress", (float(min(max(share, 0.0), 1.0)), doing)))

    try:
        result = work(progress=progress, **arguments)
    except StudioError as error:
        pipe.send(("error", str(error)))
    except MemoryError:
        pipe.send(
            (
                "error",
                "There is not enough memory for this. Close other programs, or use "
                "fewer takes, and run it again.",
            )
        )
    except Exception:
        logger.exception("A job failed")
        pipe.send(("error", "This did not work, for a reason that the server's log tells."))
    else:
        pipe.send(("result", result))
    pipe.close()
