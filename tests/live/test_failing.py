"""Where policies fail is found without a screen, and gone to with a person at hand."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live import headless
from evastudio.live.approach import LONGEST, approach
from evastudio.live.failing import NEAR, STRANGE, find_failures
from evastudio.live.stage import Stage
from evastudio.live.status import Mode, Phase
from evastudio.pilots.straight import StraightPilot
from evastudio.pilots.why import Reasoner
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from tests.live.acting import run

BEFORE = 45
"""Decision steps: 3 s."""


def test_a_failure_that_was_found_happens_again_unless_somebody_steers(
    workspace: Workspace, stage: Stage, scene: Scene, store: Store
) -> None:
    told = find_failures(workspace, "straight", options=dict(scene.values), worlds=64, most=2)
    assert told["failed"] >= len(told["failures"]) == 2
    failure = told["failures"][0]
    end = round(failure["seconds"] / scene.dt_s)
    assert failure["outcome"] == "hit"

    pilot = StraightPilot()
    reasoner = Reasoner(pilot)

    def go() -> None:
        start = approach(scene, pilot, failure["seed"], end - BEFORE, reasoner)
        stage.play(scene, pilot, failure["seed"], 0.0, 0.0, reasoner, start)
        assert (stage.phase, stage.mode) == (Phase.PAUSED, Mode.PLAY)
        assert stage.run.steps == end - BEFORE

    go()
    stage.resume(0.0)
    run(stage, 0.0, 3.1)
    assert (stage.phase, stage.run.outcome, stage.run.steps) == (Phase.ENDED, "hit", end)

    go()
    stage.touch(5.0, 0.0)
    assert (stage.phase, stage.mode) == (Phase.RECORDING, Mode.CORRECT)
    stage.keys.hold(["KeyA"], stage.clock.world_time(5.0))
    now = run(stage, 5.0, 2.0)
    stage.hand_back(0.0)
    assert stage.act.plays
    run(stage, now, 2.0)
    assert stage.run.steps > end
    assert stage.recorder is not None
    stage.stop(0.0)
    stage.recorder.close(0.0)
    (take,) = store.takes(stage.recorder.session)
    data = store.load_take(take.id)
    assert take.origin == Origin(end - BEFORE, policy="straight", seed=failure["seed"])
    again = replay_take(scene, take, data)
    assert np.array_equal(again["position"], data.snapshots["position"])


def test_where_no_world_fails_the_closest_calls_are_told(workspace: Workspace) -> None:
    told = find_failures(workspace, "straight", options={"density": 0.3}, worlds=4, seed=2)
    assert (told["worlds"], told["failed"]) == (4, 0)
    assert {one["outcome"] for one in told["failures"]} == {NEAR}
    assert all(one["seconds"] > 0.0 for one in told["failures"])


def test_where_nothing_can_go_wrong_the_strangest_moments_are_told(workspace: Workspace) -> None:
    few = {"people": 20.0}
    headless.record(workspace, "crowd", minutes=0.5, options=few, session="shown")
    headless.fit(workspace, "shown", delay="off", name="own")
    told = find_failures(workspace, "own", options=few, worlds=2, most=1)
    assert (told["failed"], [one["outcome"] for one in told["failures"]]) == (0, [STRANGE])
    told = find_failures(workspace, "straight", scene="crowd", options=few, worlds=1)
    assert told["failures"] == []


def test_a_world_that_ends_before_one_is_there_is_no_place_to_go(scene: Scene) -> None:
    pilot = StraightPilot()
    with pytest.raises(ConflictError, match="Look for failures again"):
        approach(scene, pilot, 1, 1000, Reasoner(pilot))
    with pytest.raises(InvalidInputError, match="farther"):
        approach(scene, pilot, 1, LONGEST + 1, Reasoner(pilot))
