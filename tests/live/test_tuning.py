"""Tuning a recorded session: a report, and a policy that keeps it."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path

import pytest
from distributed import Client

import evastudio
from benchmarks.local_cluster import LocalCluster
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.learning.candidates import Candidate
from evastudio.live import headless
from evastudio.live.jobs import ENDED, Job, Jobs, JobState
from evastudio.live.tuning import tune
from evastudio.workspace import Workspace


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A workspace with one session of three takes, number 1."""
    workspace = Workspace(tmp_path_factory.mktemp("recorded"))
    evastudio.record(workspace, "asteroids", minutes=1.5, seed=4, clock=lambda: 1000.0)
    return workspace


def test_what_is_fitted_is_what_tuning_chose_and_the_file_says_why(recorded: Workspace) -> None:
    heard: list[float] = []
    report = evastudio.tune(recorded, 1, progress=lambda share, doing: heard.append(share))
    assert heard == sorted(heard)
    assert heard[-1] == 1.0
    assert list(report["perceptions"]) == ["canonical", "paper"]
    fitted = evastudio.fit(recorded, 1, learner="auto", name="chosen", clock=lambda: 0.0)
    assert fitted["learner"] == report["chosen"]["learner"]
    assert fitted["report"][1:] == report["sentences"]  # the first is about the delay
    policy = evastudio.load_policy(fitted["file"])
    assert policy.extra["tuning"] == {key: report[key] for key in report if key != "session"}
    settings = {**Candidate(fitted["learner"]).make().get_params(), **report["chosen"]["settings"]}
    assert policy.settings == settings
    assert "--learner auto" in policy.made_by


def test_the_tuned_policy_flies_about_as_well_as_the_defaults(recorded: Workspace) -> None:
    evastudio.fit(recorded, 1, learner="auto", name="tuned")
    evastudio.fit(recorded, 1, name="usual")
    found = evastudio.evaluate(
        recorded, ["tuned", "usual"], worlds=40, seed=11, options={"half_width": 100.0}
    )["policies"]
    assert found["tuned"]["succeeded"] >= found["usual"]["succeeded"] - 2


def test_the_workers_of_a_cluster_do_the_trials_and_report_the_same(
    recorded: Workspace, tmp_path: Path
) -> None:
    asked = {"learner": "knn", "perception": "canonical"}
    cluster = LocalCluster(tmp_path)
    with contextlib.closing(cluster):
        cluster.work(2)
        report = evastudio.tune(recorded, 1, cluster=cluster.address, **asked)
        with Client(cluster.address, set_as_default=False) as client:
            done = client.run(lambda dask_worker: dask_worker.state.executed_count)
    assert sum(done.values()) >= len(report["trials"])
    assert report == evastudio.tune(recorded, 1, **asked)


def test_a_cleaned_session_is_tuned_as_it_was_cleaned(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "work")
    evastudio.record(workspace, "asteroids", "scripted:human", 1.0, seed=4)
    evastudio.clean(workspace, 1, threshold=0.3)
    report = evastudio.tune(workspace, 1, learner="knn")
    assert {row["threshold"] for row in report["trials"]} == {0.3}
    assert report["cleaning"] is not None


def test_what_cannot_be_tuned_is_refused_in_a_sentence(recorded: Workspace) -> None:
    with pytest.raises(NotFoundError, match="auto"):
        evastudio.tune(recorded, 1, learner="oracle")
    with pytest.raises(NotFoundError, match="canonical"):
        evastudio.tune(recorded, 1, perception="xray")
    with pytest.raises(InvalidInputError, match="Name a learner"):
        evastudio.fit(recorded, 1, learner="auto", settings={"k": 3})
    with Store(recorded.store_url) as store:
        scene = headless.make_scene(recorded, "asteroids")
        empty = store.create_session(scene, "Empty", "test", 0.0)
    with pytest.raises(InvalidInputError, match="Record a take first"):
        evastudio.tune(recorded, empty)


def test_tuning_in_a_job_is_cancelled_half_way(recorded: Workspace) -> None:
    changed = threading.Event()
    under_way = threading.Event()

    def note(job: Job) -> None:
        if job.state in ENDED:
            changed.set()
        if job.progress > 0.1:
            under_way.set()

    jobs = Jobs(note)
    try:
        job = jobs.submit("tune", tune, 1, workspace=recorded)
        assert under_way.wait(60.0)
        assert jobs.worker(job.id) is not None
        jobs.cancel(job.id)
        assert changed.wait(60.0)
        assert jobs.get(job.id).state is JobState.CANCELLED
    finally:
        jobs.close()
    assert jobs.worker(job.id) is None
