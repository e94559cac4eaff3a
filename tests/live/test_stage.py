"""The stage's states, and its clock, with times given by the test."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live.act import COUNTDOWN_S
from evastudio.live.picture import Picture
from evastudio.live.stage import Stage
from evastudio.live.status import Phase
from evastudio.pilots.straight import StraightPilot
from evastudio.world.scene import Scene
from tests.live.acting import run

DT = 1 / 15


def test_a_take_goes_from_countdown_to_recording(stage: Stage, scene: Scene) -> None:
    assert stage.phase is Phase.READY
    stage.demonstrate(scene, 5, 0.0, 0.0)
    assert stage.status(1.0).countdown_s == pytest.approx(COUNTDOWN_S - 1.0)
    now = run(stage, 0.0, COUNTDOWN_S + 0.002)
    assert stage.phase is Phase.RECORDING
    run(stage, now, 2.0)
    status = stage.status(now + 2.0)
    assert status.pairs == 30
    assert status.seconds == pytest.approx(2.0)
    assert (status.late_steps, status.steps) == (0, 30)


def test_keys_held_before_the_step_turn_the_ship(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 0.002)
    stage.keys.hold(["KeyA"], now)
    run(stage, now, 1.0)
    assert stage.snapshot["heading"][0, 0] > 0.5


def test_without_a_session_a_demonstration_is_refused(scene: Scene) -> None:
    with pytest.raises(ConflictError, match="session"):
        Stage(scene, 1, 0.0).demonstrate(scene, 2, 0.0, 0.0)


def test_a_pause_holds_everything_and_loses_nothing(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 1.004)
    before = stage.status(now).pairs
    stage.pause(now)
    assert stage.phase is Phase.PAUSED
    moment = stage.snapshot
    now = run(stage, now, 30.0)
    assert stage.snapshot is moment
    stage.resume(now)
    run(stage, now, 1.004)
    status = stage.status(now)
    assert status.pairs == before + 15
    assert status.late_steps == 0


def test_a_pause_in_the_countdown_holds_the_countdown(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    run(stage, 0.0, 1.0)
    stage.pause(1.0)
    run(stage, 1.0, 60.0)
    stage.resume(61.0)
    assert stage.status(61.0).countdown_s == pytest.approx(COUNTDOWN_S - 1.0)


def test_discarding_and_undoing(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    run(stage, 0.0, COUNTDOWN_S + 1.0)
    assert stage.discard(0.0)
    assert stage.phase is Phase.READY
    assert stage.status(0.0).can_undo
    assert stage.undo()
    assert not stage.undo()
    assert not stage.status(0.0).can_undo


def test_backspace_in_a_countdown_leaves_the_take_before_alone(
    stage: Stage, store: Store, scene: Scene
) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 1.0)
    stage.demonstrate(scene, 6, now, 0.0)
    now = run(stage, now, 1.0)
    stage.pause(now)
    assert not stage.discard(0.0)
    assert stage.phase is Phase.READY
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    record = store.session(stage.recorder.session)
    assert (record.takes_kept, record.takes_trashed) == (1, 0)


def test_a_pilot_that_gives_nan_is_refused(stage: Stage, scene: Scene) -> None:
    class Broken(StraightPilot):
        name = "broken"

        def act(self, scene, snapshot, memory):  # type: ignore[no-untyped-def]
            actions, memory = super().act(scene, snapshot, memory)
            return actions * np.nan, memory

    stage.play(scene, Broken(), 9, 0.0, 0.0)
    with pytest.raises(InvalidInputError, match="NaN"):
        run(stage, 0.0, 1.0)


def test_a_take_ends_with_its_outcome(
    stage: Stage, store: Store, asteroids: Callable[..., Scene]
) -> None:
    crowded = asteroids(density=10.0)
    stage.demonstrate(crowded, 5, 0.0, 0.0)
    run(stage, 0.0, COUNTDOWN_S + 37.0, every=0.01)
    assert stage.phase is Phase.ENDED
    assert stage.recorder is not None
    stage.recorder.close(0.0)
    take = store.takes(stage.recorder.session)[0]
    assert take.outcome in {"hit", "crossed"}
    assert take.outcome == stage.status(0.0).outcome
    assert take.pairs == stage.status(0.0).pairs


def test_a_pilot_plays_and_nothing_is_recorded(stage: Stage, store: Store, scene: Scene) -> None:
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    run(stage, 0.0, 2.0)
    assert stage.phase is Phase.PLAYING
    assert stage.status(2.0).policy == "straight"
    assert stage.snapshot["position"][0, 0] == pytest.approx(30 * 10 / 15, abs=1.0)
    stage.stop(2.0)
    assert stage.phase is Phase.READY
    assert stage.recorder is not None
    assert store.takes(stage.recorder.session) == []


def test_the_clock_does_not_drift_when_calls_come_late(stage: Stage, scene: Scene) -> None:
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    rng = np.random.default_rng(0)
    now = 0.0
    while now < 20.0:
        now = stage.advance(now, 0.0) + float(rng.uniform(0.0, 0.03))
    assert stage.clock.steps == int(now / DT) or stage.clock.steps == int(now / DT) - 1
    assert stage.status(now).late_steps == 0


def test_late_steps_are_counted_and_a_standstill_is_not_caught_up(
    stage: Stage, scene: Scene
) -> None:
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    now = run(stage, 0.0, 1.0)
    steps = stage.clock.steps
    stage.advance(now + 0.3, 0.0)
    assert stage.clock.steps - steps in {4, 5}
    assert stage.clock.late_steps in {3, 4}
    late, steps = stage.clock.late_steps, stage.clock.steps
    stage.advance(now + 60.0, 0.0)
    assert stage.clock.late_steps - late > 800
    assert stage.clock.steps == steps


def test_drawing_moves_evenly_between_decisions(stage: Stage, scene: Scene) -> None:
    seen: list[float] = []
    fresh: list[bool] = []

    def show(picture: Picture) -> None:
        seen.append(float(picture.snapshot["position"][0, 0]))
        fresh.append(picture.fresh)

    stage.watch(show)
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    run(stage, 0.0, 2.0, every=1 / 240)
    moved = np.diff(seen)[10:]
    assert moved.mean() == pytest.approx(10 / 60, rel=0.05)
    assert (moved >= -1e-9).all()
    assert moved.max() < 2.2 * 10 / 60
    assert fresh.count(True) == 1


def test_what_a_decision_led_to_is_seen_in_a_moment(stage: Stage, scene: Scene) -> None:
    now, drawn = 0.0, list[tuple[float, int]]()
    stage.watch(lambda picture: drawn.append((now, stage.clock.steps)))
    stage.play(scene, StraightPilot(), 9, 0.0, 0.0)
    while now < 2.0:
        now = stage.advance(now, 0.0)
    after = [at - steps * DT for at, steps in drawn]
    first = [past for past, (_, steps) in zip(after, drawn, strict=True) if steps and past < 0.01]
    assert len(first) >= 28
    assert all(0.001 < past < 0.005 for past in first)
    assert np.diff([at for at, _ in drawn][4:]).max() < 1.05 / scene.render_hz
