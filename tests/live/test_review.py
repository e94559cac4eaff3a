"""Looking back at runs, going on from any moment of them, and taking over from what plays."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED, Origin, TakeData, TakeRecord
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live import moments
from evastudio.live import reel as reels
from evastudio.live.act import COUNTDOWN_S
from evastudio.live.reel import Reel
from evastudio.live.stage import Stage
from evastudio.live.status import Mode, Phase
from evastudio.pilots.scripted import find_pilot
from evastudio.pilots.straight import StraightPilot
from evastudio.world.scene import Scene
from tests.live.acting import run

DT = 1 / 15


def taken(store: Store, stage: Stage) -> list[tuple[TakeRecord, TakeData]]:
    """What is stored of the session, once everything is written."""
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    return [(take, store.load_take(take.id)) for take in store.takes(stage.recorder.session)]


def replays(scene: Scene, take: TakeRecord, data: TakeData) -> bool:
    again = replay_take(scene, take, data)
    return all(np.array_equal(again[name], array) for name, array in data.snapshots.moving.items())


def test_any_moment_of_a_take_is_the_start_of_another(
    stage: Stage, scene: Scene, store: Store
) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    stage.keys.hold(["KeyA"], 1.0)
    now = run(stage, 0.0, COUNTDOWN_S + 2.0)
    assert stage.recorder is not None
    stage.stop(0.0)
    stage.recorder.close(0.0)
    (first,) = store.takes(stage.recorder.session)
    data = store.load_take(first.id)

    stage.recorder = Recorder(store, first.session)
    stage.review(Reel.of_take(scene, first, data), 0.0, now)
    assert (stage.phase, stage.mode) == (Phase.REVIEWING, Mode.REVIEW)
    stage.seek(12.4, now)
    status = stage.status(now)
    assert (status.take, status.position_s) == (first.id, pytest.approx(12.4 * DT))
    moment, origin = stage.here()
    assert origin == Origin(12, take=first.id)
    assert np.array_equal(moment["position"][0], data.snapshots["position"][12])

    stage.demonstrate(scene, 5, now, 0.0, start=moment, origin=origin)
    now = run(stage, now, COUNTDOWN_S + 1.0)
    stage.stop(0.0)
    (_, (fork, forked)) = taken(store, stage)
    assert (fork.seed, fork.origin) == (RECORDED, origin)
    assert np.array_equal(forked.snapshots["position"][0], data.snapshots["position"][12])
    assert replays(scene, fork, forked)


def test_a_look_back_goes_on_at_any_speed_and_stops_at_the_ends(stage: Stage, scene: Scene) -> None:
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    now = run(stage, 0.0, 3.02)
    steps = stage.run.reel.last
    assert steps == 45
    stage.review(stage.run.reel, float(steps), now)
    shown: list[float] = []
    stage.watch(lambda picture: shown.append(float(picture.snapshot["position"][0, 0])))
    stage.roll(-2.0, now)
    now = run(stage, now, 1.0)
    position = stage.status(now).position_s
    assert position == pytest.approx(steps * DT - 2.0, abs=0.01)
    assert shown == sorted(shown, reverse=True)
    assert len(set(shown)) > 20
    now = run(stage, now, 2.0)
    assert (stage.status(now).position_s, stage.status(now).speed) == (0.0, 0.0)
    with pytest.raises(InvalidInputError, match="speed"):
        stage.roll(20.0, now)
    stage.stop(0.0)
    with pytest.raises(ConflictError, match="looked back"):
        stage.seek(0.0, now)


def test_a_long_run_forgets_its_beginning(
    stage: Stage, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reels, "MOST_BYTES", 1000)
    monkeypatch.setattr(moments, "BLOCK", 4)
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    run(stage, 0.0, 3.02)
    assert stage.run.reel.first > 0
    assert stage.run.reel.last == 45
    first, beginning = stage.run.reel.moment(stage.run.reel.first), stage.run.reel.moment(0)
    assert beginning["steps"][0] == first["steps"][0] > 0
    assert stage.run.reel.bytes <= 1000


def test_taking_over_is_a_take_of_its_own_and_handing_back_goes_on(
    stage: Stage, scene: Scene, store: Store
) -> None:
    pilot = find_pilot("scripted:careful")
    stage.play(scene, pilot, 9, 0.0, 0.0)
    now = run(stage, 0.0, 2.02)
    before = stage.snapshot
    stage.take_over(now, 0.0)
    assert (stage.phase, stage.mode) == (Phase.RECORDING, Mode.CORRECT)
    assert stage.snapshot is before
    assert stage.status(now).policy == pilot.name
    stage.keys.hold(["KeyA"], stage.clock.world_time(now))
    now = run(stage, now, 1.0)
    assert stage.snapshot["heading"][0, 0] > before["heading"][0, 0] + 0.3
    stage.hand_back(0.0)
    assert stage.phase is Phase.PLAYING
    run(stage, now, 1.0)
    assert stage.run.reel.last == 60
    stage.stop(0.0)
    ((correction, data),) = taken(store, stage)
    assert correction.origin == Origin(30, policy=pilot.name, seed=9)
    assert correction.pairs == 15
    assert replays(scene, correction, data)
    with pytest.raises(ConflictError, match="taken over"):
        stage.hand_back(0.0)


def test_slow_motion_records_in_the_worlds_own_time(
    stage: Stage, scene: Scene, store: Store
) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 0.002)
    stage.keep_pace(0.25, now)
    stage.keys.hold(["KeyA"], stage.clock.world_time(now))
    run(stage, now, 4.0)
    stage.stop(0.0)
    ((take, data),) = taken(store, stage)
    assert take.pairs in {14, 15}
    # The control's ramp takes as long as ever in the world's time, not four times fewer steps.
    steer = np.abs(data.actions[:, 0])
    ramp = next(
        control.ramp_s
        for control in scene.controls
        if "KeyA" in control.negative + control.positive
    )
    full = int(np.argmax(steer > 0.999 * steer.max()))
    assert full * DT == pytest.approx(ramp, abs=2 * DT)
    with pytest.raises(InvalidInputError, match="pace"):
        stage.keep_pace(0.1, now)


def test_leaving_a_look_back_goes_on_with_the_take_that_was_left(
    stage: Stage, scene: Scene, store: Store
) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    stage.keys.hold(["KeyA"], 1.0)
    now = run(stage, 0.0, COUNTDOWN_S + 1.0)
    steps, stood = stage.run.steps, stage.snapshot
    stage.review(stage.present.run.reel, 3.0, now)
    stage.seek(7.0, now)
    assert (stage.phase, stage.here()[1].step) == (Phase.REVIEWING, 7)
    stage.review(stage.present.run.reel, 0.0, now)
    stage.leave()
    assert (stage.phase, stage.mode, stage.run.steps) == (Phase.PAUSED, Mode.DEMONSTRATE, steps)
    assert stage.snapshot is stood
    with pytest.raises(ConflictError, match="looked back"):
        stage.leave()
    stage.resume(now)
    run(stage, now, 1.0)
    stage.stop(0.0)
    ((take, data),) = taken(store, stage)
    assert take.pairs == steps + 15
    assert replays(scene, take, data)


def test_a_take_thrown_away_while_looking_back_is_left_first(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 1.0)
    stage.review(stage.present.run.reel, 3.0, now)
    assert stage.discard(0.0)
    assert stage.phase is Phase.READY


def test_leaving_goes_back_to_the_end_of_what_played(stage: Stage, scene: Scene) -> None:
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    now = run(stage, 0.0, 1.02)
    stage.review(stage.present.run.reel, 0.0, now)
    stage.leave()
    assert (stage.phase, stage.mode) == (Phase.PAUSED, Mode.PLAY)
    stage.resume(now)
    run(stage, now, 1.0)
    assert stage.run.reel.last == 30
