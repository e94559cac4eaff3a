"""What a person does on a stage against the clock: forks, corrections, the end of a take kept."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError
from evastudio.live.headless import make_scene
from evastudio.live.live_stage import LiveStage
from evastudio.live.stages import Stages
from evastudio.workspace import Workspace

WAIT_S = 60.0
SPARSE = {"density": 0.1}


@pytest.fixture
def stage(workspace: Workspace, store: Store) -> Iterator[LiveStage]:
    stages = Stages(workspace, store)
    yield stages.open("asteroids", SPARSE, seed=4)
    stages.close_all()


def when(stage: LiveStage, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """The first status for which that holds."""
    found: list[dict[str, Any]] = []
    came = threading.Event()

    def told(status: dict[str, Any]) -> None:
        if not found and holds(status):
            found.append(status)
            came.set()

    stage.on_status.append(told)
    stage.refresh()
    assert came.wait(WAIT_S)
    stage.on_status.remove(told)
    return found[0]


def recorded(stage: LiveStage, pairs: int) -> dict[str, Any]:
    return when(stage, lambda told: told["phase"] == "recording" and told["pairs"] >= pairs)


def test_a_take_forks_and_the_fork_can_be_tried_again(
    stage: LiveStage, store: Store, workspace: Workspace
) -> None:
    stage.demonstrate()
    recorded(stage, 8)
    stage.stop()
    told = when(stage, lambda told: told["takes_kept"] == 1)
    session = told["session"]["id"]
    (first,) = store.takes(session)

    stage.looking_back.review(first.id, 0.2)
    assert stage.status()["position_s"] == pytest.approx(0.2)
    stage.looking_back.seek(4 / 15 + 0.001)
    stage.looking_back.fork()
    recorded(stage, 3)
    stage.restart(same=True)
    recorded(stage, 3)
    stage.stop()
    when(stage, lambda told: told["takes_kept"] == 3)
    forks = store.takes(session)[1:]
    begin = store.load_take(first.id).snapshots["position"][4]
    for fork in forks:
        assert fork.origin is not None
        assert (fork.origin.take, fork.origin.step) == (first.id, 4)
        data = store.load_take(fork.id)
        assert np.array_equal(data.snapshots["position"][0], begin)
        again = replay_take(make_scene(workspace, "asteroids", SPARSE), fork, data)
        assert np.array_equal(again["position"], data.snapshots["position"])


def test_a_correction_is_recorded_from_where_one_took_over(stage: LiveStage, store: Store) -> None:
    stage.play("straight")
    when(stage, lambda told: told["phase"] == "playing" and told["seconds"] > 0.4)
    stage.hold(["KeyA"], by="page")
    stage.correcting.take_over()
    told = recorded(stage, 5)
    assert (told["mode"], told["policy"]) == ("correct", "straight")
    stage.correcting.hand_back()
    stage.hold([], by="page")
    told = when(stage, lambda told: told["phase"] == "playing" and told["takes_kept"] == 1)
    (take,) = store.takes(told["session"]["id"])
    assert take.origin is not None
    assert take.origin.policy == "straight"
    turn = stage.scene.action.high[0]
    assert store.load_take(take.id).actions[-1, 0] > 0.5 * turn
    with pytest.raises(ConflictError, match="taken over"):
        stage.correcting.hand_back()


def test_the_last_seconds_of_a_running_take_can_be_kept(stage: LiveStage, store: Store) -> None:
    with pytest.raises(ConflictError, match="no take"):
        stage.looking_back.keep_last(1.0)
    stage.demonstrate()
    recorded(stage, 15)
    stage.looking_back.keep_last(0.4)
    told = when(stage, lambda told: told["takes_kept"] == 1)
    (kept,) = store.takes(told["session"]["id"])
    assert kept.pairs == 6
    (whole,) = store.takes(told["session"]["id"], trashed=True)
    assert kept.origin is not None
    assert (kept.origin.take, kept.origin.step) == (whole.id, whole.pairs - 6)


def test_the_same_world_can_be_flown_again(stage: LiveStage) -> None:
    stage.demonstrate()
    seed = recorded(stage, 1)["seed"]
    stage.restart(same=True)
    assert stage.status()["seed"] == seed
    stage.restart()
    assert stage.status()["seed"] != seed


def test_another_take_begins_where_one_was_thrown_away(stage: LiveStage) -> None:
    stage.demonstrate(pushes=True)
    seed = recorded(stage, 3)["seed"]
    assert stage.discard()
    told = stage.status()
    assert (told["phase"], told["mode"], told["pushes"]) == ("ready", None, False)
    stage.restart()
    told = stage.status()
    assert (told["phase"], told["mode"], told["pushes"]) == ("countdown", "demonstrate", True)
    assert told["seed"] != seed


def test_slow_motion_holds_for_the_stage(stage: LiveStage) -> None:
    stage.keep_pace(0.5)
    stage.demonstrate()
    assert recorded(stage, 4)["pace"] == 0.5
