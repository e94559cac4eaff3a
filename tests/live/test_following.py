"""Sticks, slow motion and takes that follow one another, on a stage against the clock."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations.store import Store
from evastudio.live.inputs import Feel
from evastudio.live.live_stage import LiveStage
from evastudio.live.series import Arrangement
from evastudio.live.stages import Stages
from evastudio.workspace import Workspace
from tests.live.test_directing import recorded, when

SPARSE = {"density": 0.1}


@pytest.fixture
def store_url(tmp_path: Path) -> str:
    """One database is enough: nothing here is about stores."""
    return f"sqlite:///{tmp_path / 'store.db'}"


@pytest.fixture
def stage(workspace: Workspace, store: Store) -> Iterator[LiveStage]:
    stages = Stages(workspace, store)
    yield stages.open("asteroids", SPARSE, seed=4)
    stages.close_all()


def test_a_stick_in_slow_motion_is_recorded_in_the_worlds_time(
    stage: LiveStage, store: Store
) -> None:
    stage.suit(Feel(sensitivity=0.5))
    stage.keep_pace(0.5)
    stage.demonstrate()
    recorded(stage, 3)
    stage.hold([], by="page", pushed={"theta": 0.6, "phi": -1.0, "wings": 1.0})
    recorded(stage, 10)
    told = recorded(stage, 12)
    assert told["pace"] == 0.5
    stage.stop()
    told = when(stage, lambda told: told["takes_kept"] == 1)
    (take,) = store.takes(told["session"]["id"])
    data = store.load_take(take.id)
    bound = stage.scene.action.high
    assert data.actions[-1] == pytest.approx([0.3 * bound[0], -0.5 * bound[1]])
    assert take.pairs == len(data.actions)
    assert np.diff(data.snapshots["position"][:, 0]).max() <= 10 * stage.scene.dt_s + 1e-9


def test_several_hands_add_up_and_whoever_lets_go_is_out(stage: LiveStage, store: Store) -> None:
    stage.demonstrate()
    recorded(stage, 2)
    stage.hold([], by="one", pushed={"theta": 0.25})
    stage.hold([], by="other", pushed={"theta": 0.5})
    recorded(stage, 6)
    stage.hold([], by="other")
    recorded(stage, 12)
    stage.stop()
    told = when(stage, lambda told: told["takes_kept"] == 1)
    (take,) = store.takes(told["session"]["id"])
    turned = store.load_take(take.id).actions[:, 0] / stage.scene.action.high[0]
    assert turned.max() == pytest.approx(0.75)
    assert turned[-1] == pytest.approx(0.25)


def test_takes_follow_one_another_until_as_many_are_kept_as_wanted(
    stage: LiveStage, store: Store
) -> None:
    stage.arrange(Arrangement(wanted=2, automatic=True, rest_s=0.1))
    stage.demonstrate()
    seeds = [recorded(stage, 3)["seed"]]

    def following() -> int:
        when(stage, lambda told: told["seed"] not in seeds and told["phase"] == "recording")
        told = recorded(stage, 3)
        seeds.append(told["seed"])
        return int(told["takes_kept"])

    stage.discard()
    assert following() == 0
    stage.end_take()
    assert following() == 1
    stage.end_take()
    told = when(stage, lambda told: told["takes_kept"] == 2)
    told = when(stage, lambda told: told["next_s"] is None)
    assert told["phase"] == "ready"
    assert [take.seed for take in store.takes(told["session"]["id"])] == seeds[1:]


def test_after_a_stop_no_take_begins_by_itself(stage: LiveStage) -> None:
    stage.arrange(Arrangement(automatic=True, rest_s=30.0))
    stage.demonstrate()
    recorded(stage, 2)
    stage.end_take()
    assert when(stage, lambda told: told["next_s"] is not None)["next_s"] <= 30.0
    stage.stop()
    assert stage.status()["next_s"] is None


def test_a_stick_pushed_far_takes_over_from_what_plays(stage: LiveStage, store: Store) -> None:
    stage.need_session()
    stage.play("straight")
    when(stage, lambda told: told["phase"] == "playing" and told["seconds"] > 0.2)
    stage.hold([], by="page", pushed={"theta": 0.2})
    assert stage.status()["mode"] == "play"
    stage.hold([], by="page", pushed={"theta": 0.9})
    told = recorded(stage, 4)
    assert told["mode"] == "correct"
