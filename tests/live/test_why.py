"""Why did it do that? The moments a decision came from; one forgotten counts at once no more."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, NotFoundError
from evastudio.live import headless
from evastudio.live.live_stage import LiveStage
from evastudio.live.stages import Stages
from evastudio.pilots.why import Why
from evastudio.workspace import Workspace

WAIT_S = 60.0
DENSE = {"density": 4.0}


@pytest.fixture
def workspace(workspace: Workspace) -> Workspace:
    headless.record(workspace, "asteroids", minutes=0.5, seed=3, options=DENSE, session="shown")
    headless.fit(workspace, "shown", learner="knn", settings={"k": 3}, delay="off", name="exact")
    headless.fit(workspace, "shown", learner="svr", delay="off", name="smooth")
    return workspace


@pytest.fixture
def stage(workspace: Workspace) -> Iterator[LiveStage]:
    with Store(workspace.store_url) as store:
        stages = Stages(workspace, store)
        yield stages.open("asteroids", DENSE, seed=4)
        stages.close_all()


def played(stage: LiveStage, seconds: float) -> Why:
    """Why it decided as it did, after so much more of a playback, which is then paused."""
    seconds += stage.status()["seconds"]
    came = threading.Event()

    def told(status: dict[str, Any]) -> None:
        if status["phase"] == "playing" and status["seconds"] >= seconds:
            came.set()

    stage.on_status.append(told)
    stage.refresh()
    assert came.wait(WAIT_S)
    stage.on_status.remove(told)
    stage.pause()
    why = stage.correcting.why()
    assert why is not None
    return why


def test_a_decision_comes_from_moments_that_the_store_has(
    stage: LiveStage, workspace: Workspace
) -> None:
    stage.play("exact")
    why = played(stage, 3.0)
    assert why.policy == "exact"
    assert why.moments is not None
    assert why.actions is not None
    assert (why.distances[1:] >= why.distances[:-1]).all()
    assert why.weights.sum() == pytest.approx(1.0)
    assert 0.0 <= (why.familiarity or 0.0) <= 1.0
    with Store(workspace.store_url) as store:
        data = store.load_take(int(why.moments[0, 0]))
    scene = stage.scene
    view = scene.perceptions["canonical"]
    moment = data.snapshots.take(slice(int(why.moments[0, 1]), int(why.moments[0, 1]) + 1))
    percept = view.perceive(moment)
    shown = view.to_own(percept.frame, data.actions[int(why.moments[0, 1])][None])
    here = view.to_own(view.perceive(_decided_at(stage)).frame, why.actions[:1])
    assert here == pytest.approx(shown, abs=1e-9)


def _decided_at(stage: LiveStage) -> Any:
    """The moment of the latest decision."""
    stage.looking_back.review(None, 0.0)
    last = round(stage.status()["length_s"] / stage.scene.dt_s) - 1
    stage.looking_back.seek((last + 0.001) * stage.scene.dt_s)
    return stage.snapshot


def test_looking_back_every_decision_tells_why(stage: LiveStage) -> None:
    stage.play("exact")
    latest = played(stage, 3.0)
    stage.looking_back.review(None, 2.0)
    early = stage.correcting.why()
    assert early is not None
    assert not np.array_equal(early.distances, latest.distances)
    assert stage.status()["familiarity"] == early.familiarity


@pytest.mark.parametrize("policy", ["exact", "smooth"])
def test_a_moment_forgotten_while_playing_counts_no_more(
    stage: LiveStage, workspace: Workspace, policy: str
) -> None:
    stage.play(policy)
    why = played(stage, 3.0)
    assert why.moments is not None
    take, step = why.moments[0].tolist()
    stage.correcting.forget(take, step)
    with pytest.raises(NotFoundError, match="forgotten"):
        stage.correcting.forget(take, step)
    stage.resume()
    again = played(stage, 0.1)
    assert again.moments is not None
    assert [take, step] not in again.moments.tolist()
    with Store(workspace.store_url) as store:
        session = store.session("shown")
        assert session.cleaning is not None
        assert session.cleaning.removed == 1
        assert store.marks(session.id)[take][step]
        assert store.undo_cleaning(session.id)
        assert not store.marks(session.id)


def test_what_is_left_out_changes_the_decision_that_is_looked_at(stage: LiveStage) -> None:
    stage.play("exact")
    before = played(stage, 3.0)
    assert before.moments is not None
    gone = before.moments[0].tolist()
    stage.correcting.forget(*gone)
    after = stage.correcting.why()
    assert after is not None
    assert after.moments is not None
    assert after.moments[:2].tolist() == before.moments[1:3].tolist()
    assert after.actions is not None
    assert not np.array_equal(after.actions.mean(axis=0), before.actions.mean(axis=0))


def test_what_was_left_out_stays_so_until_it_is_taken_back(
    stage: LiveStage, workspace: Workspace
) -> None:
    stage.play("exact", seed=7)
    why = played(stage, 1.0)
    assert why.moments is not None
    gone = why.moments[0].tolist()
    stage.correcting.forget(*gone)
    stage.restart(same=True)
    with pytest.raises(NotFoundError, match="forgotten"):
        stage.correcting.forget(*gone)
    with Store(workspace.store_url) as store:
        assert store.undo_cleaning(store.session("shown").id)
    stage.restart(same=True)
    stage.correcting.forget(*gone)
    # Fitted anew it is left out for good, though nothing was ever cleaned.
    fitted = headless.fit(workspace, "shown", learner="knn", delay="off", name="again")
    assert fitted["pairs"] == fitted["pairs_before_cleaning"] - 1


def test_one_comes_to_a_moment_as_the_policy_was_fitted_though_something_was_left_out(
    stage: LiveStage,
) -> None:
    stage.play("exact", seed=7, from_s=2.0)
    there = stage.snapshot["position"]
    assert stage.status()["phase"] == "paused"
    for _ in range(20):
        why = stage.correcting.why()
        assert why is not None
        assert why.moments is not None
        stage.correcting.forget(*why.moments[0].tolist())
    gone = why.moments[0].tolist()
    stage.play("exact", seed=7, from_s=2.0)
    assert np.array_equal(stage.snapshot["position"], there)
    with pytest.raises(NotFoundError, match="forgotten"):
        stage.correcting.forget(*gone)


def test_what_plays_gives_way_to_whoever_steers(stage: LiveStage, workspace: Workspace) -> None:
    stage.play("exact")
    played(stage, 1.0)
    stage.hold(["KeyA"])
    assert stage.status()["mode"] == "play"  # there is no session to record into
    stage.hold([])
    with Store(workspace.store_url) as store:
        stage.choose_session(store.session("shown").id)
    stage.play("exact")
    played(stage, 1.0)
    at = stage.status()["seconds"]
    stage.hold(["KeyQ"])
    assert stage.status()["phase"] == "paused"  # that key steers nothing
    stage.hold(["KeyA"])
    status = stage.status()
    assert (status["phase"], status["mode"], status["policy"]) == ("recording", "correct", "exact")
    stage.hold([])
    stage.correcting.hand_back()
    assert stage.status()["mode"] == "play"
    stage.stop()
    with Store(workspace.store_url) as store:
        origin = store.takes(store.session("shown").id)[-1].origin
    if origin is not None:  # steps may not have come in between
        assert (origin.policy, origin.step) == ("exact", round(at / stage.scene.dt_s))


def test_where_nothing_can_be_told_it_is_said_why(stage: LiveStage) -> None:
    stage.play("exact")
    assert played(stage, 0.5).familiarity is not None
    assert stage.status()["silent"] is None
    stage.play("asteroids-careful")
    why = played(stage, 0.5)
    assert stage.correcting.silence(why) == stage.status()["silent"]
    assert "compact form" in stage.status()["silent"]


def test_programs_have_no_reasons(stage: LiveStage) -> None:
    stage.play("straight")
    assert stage.correcting.why() is None
    with pytest.raises(NotFoundError):
        stage.correcting.forget(1, 1)
    stage.stop()
    with pytest.raises(ConflictError, match="Nothing plays"):
        stage.correcting.forget(1, 1)
