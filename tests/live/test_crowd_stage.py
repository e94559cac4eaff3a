"""A person leads one of many, and lets the boulder fall; the take replays with all of it."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.demonstrations.pairs import perceive_take
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live.act import COUNTDOWN_S
from evastudio.live.aim import ground_at
from evastudio.live.stage import Stage
from evastudio.live.status import Phase
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import shipped
from evastudio.world.bodies import Camera
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene

WALK = 3.0


@pytest.fixture
def crowd() -> Scene:
    return load_scene_file(shipped() / "scenes" / "crowd.py")(people=20, side=15)


def test_the_lead_walks_the_others_stand_and_the_boulder_falls_where_pointed(
    store: Store, crowd: Scene
) -> None:
    session = store.create_session(crowd, "Led", "test", 0.0)
    stage = Stage(crowd, 1, 0.0)
    stage.recorder = Recorder(store, session)
    stage.demonstrate(crowd, 5, 0.0, 0.0)
    start = stage.snapshot
    stage.advance(COUNTDOWN_S, 0.0)
    assert stage.phase is Phase.RECORDING
    stage.keys.hold(["ArrowUp"], COUNTDOWN_S)
    for tick in range(1, 5):
        stage.advance(COUNTDOWN_S + 0.5 * tick, 0.0)
    assert np.array_equal(stage.snapshot["position"][0, 1:], start["position"][0, 1:])
    aimed = ground_at(crowd.camera(stage.snapshot), 0.1, 0.05, 1.5)
    stage.signal("drop", (0.1, 0.05, 1.5))
    for tick in range(5, 12):
        stage.advance(COUNTDOWN_S + 0.5 * tick, 0.0)
    assert tuple(stage.snapshot["boulder"][0, :2]) == pytest.approx(aimed)
    assert stage.snapshot["boulder"][0, 2] == 3.0
    stage.stop(0.0)
    stage.recorder.close(0.0)

    (take,) = store.takes(session)
    data = store.load_take(take.id)
    again = replay_take(crowd, take, data)
    for name, array in data.snapshots.moving.items():
        assert np.array_equal(again[name], array), name
    calm = perceive_take(crowd.perceptions["paths"], data.snapshots, data.actions, take.id)
    wild = perceive_take(crowd.perceptions["boulder"], data.snapshots, data.actions, take.id)
    assert set(calm.actions[:, 0]) == {WALK}
    assert len(calm) + len(wild) == take.pairs == 11


def test_signals_that_cannot_be_given_are_refused_in_a_sentence(crowd: Scene) -> None:
    stage = Stage(crowd, 1, 0.0)
    with pytest.raises(ConflictError, match="Nothing moves"):
        stage.signal("drop")
    stage.play(crowd, find_pilot("scripted:shy"), 3, 0.0, 0.0)
    with pytest.raises(NotFoundError, match="drop"):
        stage.signal("dorp")
    with pytest.raises(InvalidInputError, match="point lower"):
        stage.signal("drop", (0.0, 1.0, 1.0))
    stage.signal("drop")
    stage.advance(0.5, 0.0)
    assert stage.snapshot["boulder"][0, 2] == 0.0


def recorded(store: Store, crowd: Scene, stage: Stage, **how: Pilot) -> int:
    """A stage of the crowd that records into a session of its own, the countdown over."""
    session = store.create_session(crowd, "Led", "test", 0.0)
    stage.recorder = Recorder(store, session)
    stage.demonstrate(crowd, 5, 0.0, 0.0, **how)
    stage.advance(COUNTDOWN_S, 0.0)
    return session


def test_the_next_decision_is_told_as_keys_change(store: Store, crowd: Scene) -> None:
    stage = Stage(crowd, 1, 0.0)
    assert stage.status(0.0).decision is None
    recorded(store, crowd, stage)
    now = COUNTDOWN_S
    assert stage.status(now + 0.1).decision == "stand"
    assert stage.status(now + 0.1).decides_s == pytest.approx(0.4)
    stage.keys.hold(["ArrowUp"], now + 0.1)
    assert stage.status(now + 0.1).decision == "walk on"
    stage.keys.hold(["ArrowUp", "KeyA"], now + 0.2)
    assert stage.status(now + 0.2).decision == "turn left"
    stage.keys.hold([], now + 0.3)  # a tap is not lost: it is what the decision will be
    assert stage.status(now + 0.4).decision == "turn left"
    heading = stage.snapshot["heading"][0, 0]
    stage.advance(now + 0.5, 0.0)
    assert stage.snapshot["heading"][0, 0] > heading
    assert stage.status(now + 0.9).decision == "stand"
    assert stage.recorder is not None
    stage.recorder.close(0.0)


def test_the_others_follow_their_own_policy_and_the_take_replays(
    store: Store, crowd: Scene
) -> None:
    stage = Stage(crowd, 1, 0.0)
    session = recorded(store, crowd, stage, others=find_pilot("scripted:hurried"))
    start = stage.snapshot
    assert stage.status(0.0).others == "scripted:hurried"
    stage.keys.hold(["KeyA"], COUNTDOWN_S)
    for tick in range(1, 13):
        stage.advance(COUNTDOWN_S + 0.5 * tick, 0.0)
    moved = np.hypot(*(stage.snapshot["position"] - start["position"])[0].T)
    assert moved[0] == 0.0
    assert np.median(moved[1:]) > 1.0
    assert stage.snapshot["heading"][0, 0] - start["heading"][0, 0] == pytest.approx(3 * np.pi)
    stage.stop(0.0)
    assert stage.status(0.0).others is None
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    (take,) = store.takes(session)
    data = store.load_take(take.id)
    again = replay_take(crowd, take, data)
    for name, array in data.snapshots.moving.items():
        assert np.array_equal(again[name], array), name


def test_another_character_is_led_in_the_next_take_and_not_in_this_one(
    store: Store, crowd: Scene
) -> None:
    stage = Stage(crowd, 1, 0.0)
    for _ in range(3):
        stage.lead_another()
    session = recorded(store, crowd, stage)
    assert stage.status(0.0).lead == 3
    with pytest.raises(ConflictError, match="about one character"):
        stage.lead_another()
    heading = stage.snapshot["heading"][0].copy()
    stage.keys.hold(["KeyD"], COUNTDOWN_S)
    for tick in range(1, 5):
        stage.advance(COUNTDOWN_S + 0.5 * tick, 0.0)
    turned = np.flatnonzero(stage.snapshot["heading"][0] != heading)
    assert turned.tolist() == [3]
    stage.stop(0.0)
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    (take,) = store.takes(session)
    data = store.load_take(take.id)
    assert set(data.snapshots["lead"]) == {3}
    again = replay_take(crowd, take, data)
    assert np.array_equal(again["heading"], data.snapshots["heading"])
    few = type(crowd)(people=2, side=15)
    stage.play(few, find_pilot("scripted:shy"), 3, 0.0, 0.0)
    assert stage.status(0.0).lead == 1


def test_the_camera_in_use_decides_where_one_points(crowd: Scene) -> None:
    stage = Stage(crowd, 1, 0.0)
    shown: list[Camera] = []
    stage.watch(lambda picture: shown.append(picture.camera))
    stage.play(crowd, find_pilot("scripted:shy"), 3, 0.0, 0.0)
    assert stage.status(0.0).cameras == ("chase", "overview")
    with pytest.raises(NotFoundError, match="overview"):
        stage.look_through("overwiev")
    stage.look_through()
    assert stage.status(0.0).camera == "overview"
    stage.advance(0.25, 0.0)
    stage.signal("drop", (0.5, 0.2, 1.5))
    stage.advance(0.5, 0.0)
    assert stage.snapshot["boulder"][0, 2] == 0.0
    aimed = ground_at(shown[0], 0.5, 0.2, 1.5)
    assert tuple(stage.snapshot["boulder"][0, :2]) == pytest.approx(aimed)
    stage.look_through()
    assert stage.status(0.0).camera == "chase"
