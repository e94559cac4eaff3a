"""A stage on its thread outlives a scene that fails, and keeps the take."""

from __future__ import annotations

import gc
import threading
import weakref
from collections.abc import Iterator
from typing import Any

import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError
from evastudio.live.stages import Stages
from evastudio.workspace import Workspace, shipped

WAIT_S = 60.0


@pytest.fixture
def stages(workspace: Workspace, store: Store) -> Iterator[Stages]:
    made = Stages(workspace, store)
    yield made
    made.close_all()


def test_a_scene_that_fails_while_it_is_looked_at_is_stopped(
    workspace: Workspace, stages: Stages
) -> None:
    source = (shipped() / "scenes" / "asteroids.py").read_text()
    failing = source.replace('name = "asteroids"', 'name = "failing"').replace(
        '        return np.asarray(np.clip(snapshot["position"]',
        '        if snapshot["steps"][0] > 3:\n            raise RuntimeError("no way")\n'
        '        return np.asarray(np.clip(snapshot["position"]',
    )
    assert failing.count("no way") == 1
    folder = workspace.root / "scenes"
    folder.mkdir()
    (folder / "failing.py").write_text(failing)
    stage = stages.open("failing", seed=1)
    stopped = threading.Event()
    problems: list[str] = []

    def note(told: dict[str, Any]) -> None:
        if told["problem"]:
            problems.append(told["problem"])
            stopped.set()

    stage.on_status.append(note)
    stage.play("straight")
    assert stopped.wait(WAIT_S)
    assert "the log tells why" in problems[0]
    assert stage.status()["phase"] == "ready"


def test_a_closed_stage_is_gone_with_all_that_it_remembers(stages: Stages) -> None:
    stage = stages.open("asteroids", seed=1)
    stage.play("straight")
    run = weakref.ref(stage._stage.run)
    stages.close(stage.name)
    del stage
    gc.collect()
    assert run() is None


def test_at_the_end_no_stage_is_opened_any_more(workspace: Workspace, store: Store) -> None:
    stages = Stages(workspace, store)
    stages.open("asteroids", seed=1)
    stages.close_all()
    assert stages.all() == []
    with pytest.raises(ConflictError, match="closed"):
        stages.open("asteroids", seed=1)


def test_a_closed_stage_refuses_and_does_not_hang(stages: Stages) -> None:
    stage = stages.open("asteroids", seed=1)
    stages.close(stage.name)
    with pytest.raises(ConflictError, match="closed"):
        stage.pause()
    with pytest.raises(ConflictError, match="closed"):
        stage.status()


def test_a_stage_is_drawn_only_while_somebody_watches(stages: Stages) -> None:
    stage = stages.open("asteroids", seed=1)
    moments: list[int] = []
    stage.watch(show := lambda picture: moments.append(int(picture.snapshot["steps"][0])))
    assert moments == [0]
    stage.unwatch(show)
    stage.play("straight")
    drawn = len(moments)
    moved = threading.Event()
    stage.on_status.append(lambda told: moved.set() if told["steps"] > 3 else None)
    assert moved.wait(WAIT_S)
    assert len(moments) == drawn
    stage.watch(show)
    assert len(moments) > drawn
