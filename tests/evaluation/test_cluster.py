"""Work on a Dask cluster: real schedulers and workers, processes of their own, over TCP."""

from __future__ import annotations

import contextlib
import importlib
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import joblib
import pytest

import evastudio
from benchmarks.local_cluster import LocalCluster
from evastudio.errors import ClusterError
from evastudio.evaluation.archive import differing
from evastudio.evaluation.cluster import on_cluster, once
from evastudio.evaluation.evaluate import evaluate
from evastudio.evaluation.results import Comparison
from evastudio.pilots.scripted import find_pilot
from evastudio.world.scene import Scene


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[LocalCluster]:
    found = LocalCluster(tmp_path)
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
    dask: LocalCluster, asteroids: Callable[..., Scene]
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


def test_a_single_worker_does_the_work_and_not_whoever_asks(dask: LocalCluster) -> None:
    (worker,) = dask.work(1)
    with on_cluster(dask.address) as everywhere:
        run = joblib.Parallel(n_jobs=everywhere)
        assert run(joblib.delayed(os.getpid)() for _ in range(3)) == [worker.pid] * 3
        sent = once((1, 2))
        assert run(joblib.delayed(sum)(sent) for _ in range(3)) == [3] * 3
    assert once((1, 2)) == (1, 2)


def test_a_cluster_that_cannot_do_the_work_says_why(dask: LocalCluster, tmp_path: Path) -> None:
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


def test_a_worker_with_other_code_of_the_same_version_is_refused(
    dask: LocalCluster, tmp_path: Path
) -> None:
    other = tmp_path / "other" / "evastudio"
    leave = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
    shutil.copytree(Path(evastudio.__file__).parent, other, ignore=leave)
    with (other / "errors.py").open("a", encoding="utf-8") as file:
        file.write("# Something has changed.\n")
    dask.work(1, PYTHONPATH=str(other.parent), PYTHONSAFEPATH="1")
    with pytest.raises(ClusterError, match=r"its code \w{12} \(here"), on_cluster(dask.address):
        pass


def test_what_a_worker_cannot_read_is_told_and_not_waited_for(
    dask: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "only_here.py").write_text("class Thing:\n    pass\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    thing = importlib.import_module("only_here").Thing()
    dask.work(1)
    with (
        pytest.raises(ClusterError, match="cannot read the Thing"),
        on_cluster(dask.address),
    ):
        once(thing)


def test_without_a_cluster_the_work_stays_here() -> None:
    with on_cluster(None) as jobs:
        assert jobs == 1
