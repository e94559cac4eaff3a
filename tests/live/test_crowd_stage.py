"""A person leads one of many, and lets the boulder fall; the take replays with all of it."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.demonstrations.pairs import perceive_take
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live.aim import ground_at
from evastudio.live.stage import COUNTDOWN_S, Phase, Stage
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
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
