"""Where nobody has been is found, gone to, and forced upon whoever wants that."""

from __future__ import annotations

import numpy as np

from evastudio.demonstrations.records import RECORDED
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.live.act import COUNTDOWN_S
from evastudio.live.live_stage import LiveStage
from evastudio.live.pushing import Push, Pushes
from evastudio.live.stage import Stage
from evastudio.live.stages import Stages
from evastudio.live.visiting import find_places
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from tests.live.acting import run

FIELD = {"density": 1.0}


def test_places_are_unlike_what_was_shown_and_takes_begin_there(workspace: Workspace) -> None:
    made = headless.record(workspace, "asteroids", minutes=1.0, options=FIELD, session="shown")
    told = find_places(workspace, made["session"], places=3, seed=5)
    places = told["places"]
    assert told == find_places(workspace, "shown", places=3, seed=5)
    assert len(places) == 3
    assert len({place["take"] for place in places}) == made["takes"]
    assert all(place["familiarity"] < 0.2 for place in places)

    place = places[0]
    with Store(workspace.store_url) as store:
        stages = Stages(workspace, store)
        stage: LiveStage = stages.open("asteroids", session=made["session"])
        push = Push(tuple(place["keys"]), place["steps"])
        stage.looking_back.visit(place["take"], place["step"], push)
        assert stage.status()["phase"] == "countdown"
        assert dict(stage.scene.values)["density"] == FIELD["density"]
        reached = stage.snapshot
        stages.close_all()
        data = store.load_take(place["take"])
    before = data.snapshots.take(slice(place["step"], place["step"] + 1))
    assert np.array_equal(push.applied(stage.scene, before)["position"], reached["position"])
    assert reached["steps"][0] == place["step"] + place["steps"]


def test_what_is_forced_is_in_no_take_and_one_goes_on_behind_it(
    stage: Stage, scene: Scene, store: Store
) -> None:
    pushes = Pushes(scene, np.random.default_rng(3), None)
    stage.demonstrate(scene, 5, 0.0, 0.0, pushes=pushes)
    pushed: list[int] = []
    now = COUNTDOWN_S
    run(stage, 0.0, COUNTDOWN_S)
    for _ in range(25 * 15):
        now = run(stage, now, scene.dt_s)
        if stage.act.pushed:
            pushed.append(stage.run.steps - 1)
    stage.stop(0.0)
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    takes = store.takes(stage.recorder.session)
    assert len(takes) >= 3
    assert pushed
    recorded: list[int] = []
    for take in takes:
        data = store.load_take(take.id)
        first = 0 if take.origin is None else take.origin.step
        recorded += range(first, first + take.pairs)
        again = replay_take(scene, take, data)
        assert np.array_equal(again["position"], data.snapshots["position"])
    assert [take.seed for take in takes[1:]] == [RECORDED] * (len(takes) - 1)
    assert not set(recorded) & set(pushed)
    assert len(recorded) + len(pushed) >= stage.run.reel.last


def test_a_push_is_the_same_whenever_it_is_given(scene: Scene) -> None:
    push = Push(("KeyA", "KeyW"), 12)
    start = scene.worlds([4])
    first, again = push.applied(scene, start), push.applied(scene, start)
    assert np.array_equal(first["position"], again["position"])
    assert first["heading"][0, 0] > start["heading"][0, 0]
