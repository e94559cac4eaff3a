"""The paper's tables from one call, at the smallest extent."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import pytest

import evastudio
from benchmarks.local_cluster import LocalCluster
from evastudio.demonstrations.store import Store
from evastudio.evaluation.paper import Extent
from evastudio.evaluation.studies import Study, save_study
from evastudio.pilots.pegasus import Pegasus
from evastudio.workspace import Workspace

SMALL = Extent(
    pairs=600,
    densities=(1.0,),
    at=1.0,
    worlds=2,
    timed=1,
    repeats=1,
    searches=(
        Pegasus("hill-climbing", hidden=2, scenarios=2, horizon_s=1.0, population=2, rounds=2),
    ),
)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("paper")
    workspace = Workspace(folder)
    with Store(workspace.ready().store_url) as store:
        save_study(store, Study("asteroids", "nobody, a test", 60.0, 90.0), 0.0)
    told = evastudio.paper(workspace, folder / "out", extent=SMALL, clock=lambda: 0.0)
    return folder / "out", told


def test_every_line_of_the_papers_tables_is_there(made: tuple[Path, dict[str, Any]]) -> None:
    _, told = made
    one, two = told["tables"]["1"], told["tables"]["2"]
    theirs = [row["paper"] for row in one if row["group"] in ("Pairs", "k-NN", "SVM")]
    assert [value for value in theirs if value is not None] == [
        *(6000, 480.0, 16.0),
        *(13e-6, 1e6, 7.04e-3, 36.1),
        *(150.0, 2e-6, 10e3, 1.13e-3, 37.7),
    ]
    assert [row["paper"] for row in two if row["paper"] is not None] == [
        *(8e9, 7 * 86400.0),
        *(8280.0, 2e-3, 5e3, 6.95, 36.6),
        *(8e6, 370e6, 0.2, 104.1, 34.7),
    ]
    unmeasured = {"Time to learn policy"}
    for row in [*one, *two]:
        searched = row["group"].startswith("PEGASUS")
        assert row["here"] is not None or searched or row["what"] in unmeasured, row
    assert told["tables"]["3"][0]["person"] == "nobody, a test"


def test_tables_and_pictures_are_files_that_say_who_flew(
    made: tuple[Path, dict[str, Any]],
) -> None:
    folder, told = made
    text = (folder / "paper.md").read_text(encoding="utf-8")
    assert "No person flew" in text
    assert "1970-01-01" in text
    assert "nobody, a test" in text
    for name in ("crossing", "learning", "paths", "paths-in-space", "actions"):
        assert f"({name}.svg)" in text
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    kept = json.loads((folder / "paper.json").read_text(encoding="utf-8"))
    assert kept["tables"]["3"] == told["tables"]["3"]
    assert {str(folder / name) for name in ("paper.md", "paper.json")} <= set(told["files"])


def test_two_workers_of_a_cluster_cross_the_same_fields(
    made: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    folder, _ = made
    cluster = LocalCluster(tmp_path)
    with contextlib.closing(cluster):
        cluster.work(2)
        evastudio.paper(
            Workspace(tmp_path / "work"),
            tmp_path / "out",
            extent=SMALL,
            cluster=cluster.address,
            clock=lambda: 0.0,
        )
    for name in ("crossing.svg", "paths.svg", "actions.svg"):
        assert (tmp_path / "out" / name).read_bytes() == (folder / name).read_bytes(), name
