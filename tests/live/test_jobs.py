"""Jobs run in processes of their own, tell how far they are, and can be ended."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import BusyError, ConflictError, NotFoundError
from evastudio.live import headless, jobs
from evastudio.live.cleaning import clean
from evastudio.live.jobs import ENDED, NICENESS, Job, Jobs, JobState
from evastudio.workspace import Workspace

WAIT_S = 60.0


class Watched:
    """Jobs, and a way to wait for one to be as wanted."""

    def __init__(self) -> None:
        self.seen: list[Job] = []
        self._changed = threading.Condition()
        self.jobs = Jobs(self._note)

    def _note(self, job: Job) -> None:
        with self._changed:
            self.seen.append(job)
            self._changed.notify_all()

    def until(self, number: int, wanted: Callable[[Job], bool]) -> Job:
        with self._changed:
            assert self._changed.wait_for(lambda: wanted(self.jobs.get(number)), WAIT_S)
        return self.jobs.get(number)

    def ended(self, number: int) -> Job:
        return self.until(number, lambda job: job.state in ENDED)


@pytest.fixture
def watched() -> Iterator[Watched]:
    made = Watched()
    yield made
    made.jobs.close()


def test_a_job_tells_its_progress_and_its_result(watched: Watched, workspace: Workspace) -> None:
    job = watched.jobs.submit(
        "record", headless.record, workspace=workspace, scene="asteroids", minutes=0.5, seed=3
    )
    ended = watched.ended(job.id)
    assert ended.state is JobState.DONE
    assert ended.result is not None
    assert ended.result["pairs"] == 450
    states = [seen.state for seen in watched.seen]
    assert states[0] is JobState.QUEUED
    assert JobState.RUNNING in states
    with Store(workspace.store_url) as store:
        assert store.session(ended.result["session"]).pairs == 450


def test_what_is_wrong_with_the_input_is_told_as_a_sentence(
    watched: Watched, workspace: Workspace
) -> None:
    job = watched.jobs.submit("fit", headless.fit, 77, workspace=workspace)
    ended = watched.ended(job.id)
    assert ended.state is JobState.FAILED
    assert ended.error is not None
    assert "no session '77'" in ended.error


def test_a_running_job_and_a_waiting_one_are_cancelled(
    watched: Watched, workspace: Workspace
) -> None:
    arguments = {"workspace": workspace, "scene": "asteroids", "minutes": 500.0}
    first = watched.jobs.submit("record", headless.record, **arguments)
    second = watched.jobs.submit("record", headless.record, **arguments)
    watched.until(first.id, lambda job: job.progress > 0.0)
    watched.jobs.cancel(second.id)
    watched.jobs.cancel(first.id)
    assert watched.ended(first.id).state is JobState.CANCELLED
    assert watched.ended(second.id).state is JobState.CANCELLED


def test_every_thread_of_a_job_gives_way_to_the_stages(
    watched: Watched, workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    job = watched.jobs.submit(
        "record", headless.record, workspace=workspace, scene="asteroids", minutes=500.0
    )
    watched.until(job.id, lambda job: job.progress > 0.0)
    worker = watched.jobs.worker(job.id)
    found = [int(thread.name) for thread in Path(f"/proc/{worker}/task").iterdir()]
    ours = os.getpriority(os.PRIO_PROCESS, 0)
    assert {os.getpriority(os.PRIO_PROCESS, thread) for thread in found} == {
        min(ours + NICENESS, 19)
    }
    watched.jobs.cancel(job.id)


def test_only_so_many_jobs_wait(watched: Watched, workspace: Workspace) -> None:
    arguments = {"workspace": workspace, "scene": "asteroids", "minutes": 500.0}
    first = watched.jobs.submit("record", headless.record, **arguments)
    watched.until(first.id, lambda job: job.state is JobState.RUNNING)
    waiting = [watched.jobs.submit("record", headless.record, **arguments) for _ in range(20)]
    with pytest.raises(BusyError, match="20 jobs wait already"):
        watched.jobs.submit("record", headless.record, **arguments)
    watched.jobs.cancel(waiting[7].id)
    assert watched.jobs.submit("record", headless.record, **arguments).state is JobState.QUEUED


def test_a_killed_worker_is_told_and_its_job_runs_again(
    watched: Watched, workspace: Workspace
) -> None:
    job = watched.jobs.submit(
        "record", headless.record, workspace=workspace, scene="asteroids", minutes=60.0, seed=5
    )
    with pytest.raises(ConflictError, match="not ended yet"):
        watched.jobs.again(job.id)
    watched.until(job.id, lambda job: job.progress > 0.0)
    worker = watched.jobs.worker(job.id)
    assert worker is not None
    os.kill(worker, signal.SIGKILL)
    ended = watched.ended(job.id)
    assert ended.state is JobState.FAILED
    assert ended.error is not None
    assert "killed from outside" in ended.error
    assert "SIGKILL" in ended.error
    assert "run it again" in ended.error
    again = watched.jobs.again(job.id)
    assert (again.id, again.kind, again.session) == (job.id + 1, job.kind, job.session)
    watched.until(again.id, lambda job: job.progress > 0.0)


def test_a_job_run_again_does_the_same_work(watched: Watched, workspace: Workspace) -> None:
    with Store(workspace.store_url) as store:
        scene = headless.make_scene(workspace, "asteroids")
        session = store.create_session(scene, "Empty", "test", 0.0)
    first = watched.jobs.submit("clean", clean, session, workspace=workspace)
    told = watched.ended(first.id)
    assert told.state is JobState.FAILED
    assert told.error is not None
    again = watched.ended(watched.jobs.again(first.id).id)
    assert (again.session, again.error) == (session, told.error)


def test_what_was_asked_long_ago_is_not_kept(
    watched: Watched, workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "ASKED", 1)
    first, second, _ = (
        watched.ended(watched.jobs.submit("fit", headless.fit, 77, workspace=workspace).id)
        for _ in range(3)
    )
    assert watched.jobs.get(first.id) == first
    with pytest.raises(ConflictError, match="Ask for it anew"):
        watched.jobs.again(first.id)
    assert watched.ended(watched.jobs.again(second.id).id).error == second.error


def test_work_ends_with_the_process_that_asked_for_it(workspace: Workspace) -> None:
    asking = (
        "import sys, time; from pathlib import Path; from evastudio.live import headless\n"
        "from evastudio.live.jobs import Jobs; from evastudio.workspace import Workspace\n"
        "if __name__ == '__main__':\n"
        "    jobs = Jobs(lambda job: print(jobs.worker(job.id), job.progress, flush=True))\n"
        "    jobs.submit('record', headless.record, workspace=Workspace(Path(sys.argv[1])),\n"
        "                scene='asteroids', minutes=9000.0)\n"
        "    time.sleep(600)\n"
    )
    program = workspace.root / "asking.py"
    program.write_text(asking)
    with subprocess.Popen(
        [sys.executable, str(program), str(workspace.root)], stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        for line in server.stdout:
            worker, progress = line.split()
            if float(progress) > 0.0:
                break
        server.kill()
        with contextlib.suppress(ProcessLookupError):
            watch = os.pidfd_open(int(worker))
            assert select.select([watch], [], [], WAIT_S)[0], "the worker goes on"
            os.close(watch)


def test_an_unknown_job_is_not_found(watched: Watched) -> None:
    with pytest.raises(NotFoundError, match="no job 9"):
        watched.jobs.get(9)
