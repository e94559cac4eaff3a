"""Work on a Dask cluster: real schedulers and workers, processes of their own, over TCP."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from distributed import Client

from evastudio.errors import ClusterError
from evastudio.evaluation.archive import differing
from evastudio.evaluation.cluster import on_cluster
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.results import Comparison
from evastudio.pilots.scripted import find_pilot
from evastudio.world.scene import Scene

Process = subprocess.Popen[str]


class Cluster:
    """A scheduler, and workers that can be started and killed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.processes: list[Process] = []
        scheduler = self._start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        assert scheduler.stderr is not None
        for line in scheduler.stderr:
            found = re.search(r"Scheduler at:\s+(tcp://\S+)", line)
            if found:
                self.address = found[1]
                return
        raise AssertionError("the scheduler ended")

    def work(self, count: int, **environment: str) -> list[Process]:
        """`count` more workers, once they have joined."""
        flags = ("--nthreads", "1", "--no-nanny", "--local-directory", str(self._folder))
        workers = [
            self._start("dask_worker", self.address, *flags, **environment) for _ in range(count)
        ]
        with Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(len(self.processes) - 1, timeout=60)
        return workers

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()
            if process.stderr is not None:
                process.stderr.close()

    def _start(self, program: str, *arguments: str, **environment: str) -> Process:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *arguments, "--no-dashboard"],
            stderr=subprocess.PIPE if program == "dask_scheduler" else subprocess.DEVNULL,
            text=True,
            env={**os.environ, **environment},
        )
        self.processes.append(process)
        return process


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Cluster]:
    found = Cluster(tmp_path)
    with contextlib.closing(found):
        yield found


def fly(scene: Scene, jobs: int, told: Callable[[float, str], None] | None = None) -> Comparison:
    pilots = {name: find_pilot(name) for name in ("scripted:careful", "scripted:human")}
    return evaluate(
        scene,
        pilots,
        worlds=12,
        seed=5,
        chunk=2,
        n_jobs=jobs,
        like="scripted:careful",
        max_steps=150,
        measure_time=False,
        progress=told,
    )


def test_two_workers_give_the_same_and_still_do_when_one_is_killed(
    dask: Cluster, asteroids: Callable[..., Scene]
) -> None:
    scene = asteroids(density=6.0)
    alone = fly(scene, 1)
    victim, _ = dask.work(2)

    def kill_once(share: float, doing: str) -> None:
        if share < 1.0 and victim.poll() is None:
            os.kill(victim.pid, signal.SIGKILL)
            victim.wait()

    with on_cluster(dask.address) as everywhere:
        together = fly(scene, everywhere)
        assert differing(alone, together) == []
        assert together.to_json() == alone.to_json()
        broken = fly(scene, everywhere, kill_once)
    assert victim.returncode == -signal.SIGKILL
    assert differing(alone, broken) == []


def test_a_cluster_that_cannot_do_the_work_says_why(dask: Cluster, tmp_path: Path) -> None:
    with (
        pytest.raises(ClusterError, match="No Dask scheduler answers"),
        on_cluster("tcp://127.0.0.1:9", 1.0),
    ):
        pass
    with pytest.raises(ClusterError, match="No Dask scheduler answers"), on_cluster("x", 1.0):
        pass
    with pytest.raises(ClusterError, match="has no worker"), on_cluster(dask.address, 1.0):
        pass
    # What a worker's packages say of themselves comes from where Python finds it first.
    (tmp_path / "scipy-0.0.1.dist-info").mkdir()
    (tmp_path / "scipy-0.0.1.dist-info" / "METADATA").write_text("Name: scipy\nVersion: 0.0.1\n")
    dask.work(1, PYTHONPATH=f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    with pytest.raises(ClusterError, match=r"scipy 0\.0\.1 \(here"), on_cluster(dask.address):
        pass


def test_without_a_cluster_the_work_stays_here() -> None:
    with on_cluster(None) as jobs:
        assert jobs == 1
