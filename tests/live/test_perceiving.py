"""A session's pairs with the reaction delay taken out, and marks that stay with their steps."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import evastudio
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.policy_files import load_policy
from evastudio.live.perceiving import see_session, unmarked
from evastudio.workspace import Workspace

STEPS, DELAY_S = 3, 0.2


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A workspace with one session, number 1, of five takes that answer 0.1 s late."""
    workspace = Workspace(tmp_path_factory.mktemp("recorded"))
    evastudio.record(workspace, "asteroids", "scripted:human", 3.0, seed=4, clock=lambda: 0.0)
    return workspace


def test_each_take_loses_the_actions_that_answer_what_was_before_it(recorded: Workspace) -> None:
    with Store(recorded.store_url) as store:
        (seen,) = see_session(recorded, store, store.session(1))
    late = seen.pairs(STEPS)
    assert seen.recorded == 2700
    assert len(late) == 2700 - STEPS * len(seen.takes)
    now = seen.pairs()
    for take in seen.takes:
        rows = late.takes == take.take
        assert late.steps[rows].tolist() == list(range(STEPS, len(take)))
        states = now.states[now.takes == take.take]
        assert np.array_equal(late.states[rows], states[: len(take) - STEPS])
    perceived = seen.perceived(STEPS)
    done = np.concatenate([take.actions[STEPS:] for take in seen.takes])
    assert np.allclose(perceived.in_world(perceived.pairs.actions), done)


def test_a_mark_stays_with_the_action_of_its_step_whatever_the_delay(recorded: Workspace) -> None:
    with Store(recorded.store_url) as store:
        (seen,) = see_session(recorded, store, store.session(1))
    late = seen.pairs(STEPS)
    conflicts = np.zeros(len(late), dtype=bool)
    conflicts[[0, 40, len(late) - 1]] = True
    marks = seen.marks(late, conflicts)
    assert {take: len(mask) for take, mask in marks.items()} == {
        take.take: len(take) for take in seen.takes
    }
    assert np.array_equal(unmarked(late, marks), ~conflicts)
    now = seen.pairs()
    gone = now.keep(~unmarked(now, marks))
    wanted = late.keep(conflicts)
    assert np.array_equal(gone.steps, wanted.steps)
    assert np.array_equal(gone.takes, wanted.takes)


def test_cleaning_and_fitting_take_the_same_delay_out(recorded: Workspace) -> None:
    found = evastudio.clean(recorded, 1, delay=DELAY_S)
    fitted = evastudio.fit(recorded, 1, learner="knn", delay=DELAY_S, name="late")
    with Store(recorded.store_url) as store:
        session = store.session(1)
        (seen,) = see_session(recorded, store, session)
        store.undo_cleaning(1)
    assert session.cleaning is not None
    assert not session.cleaning.stale
    assert session.cleaning.pairs == seen.recorded
    assert found["pairs"] == len(seen.pairs(STEPS))
    assert fitted["pairs"] == found["kept"]
    assert fitted["pairs_before_cleaning"] == 2700
    policy = load_policy(fitted["file"])
    assert policy.made_by.count(f"--delay {DELAY_S!r}") == 2
    assert policy.extra["delay"]["steps"] == STEPS


def test_a_late_demonstrator_is_told_so_and_the_policy_is_not_late(recorded: Workspace) -> None:
    fitted = evastudio.fit(recorded, 1, learner="knn", name="auto")
    off = evastudio.fit(recorded, 1, learner="knn", delay="off", name="off")
    assert 0.0 < fitted["delay_s"] < 0.2
    assert "You answered about 0.1 s late; the policy does not" in fitted["report"][0]
    assert (off["delay_s"], off["pairs"]) == (0.0, 2700)
    with Store(recorded.store_url) as store:
        assert store.identity == load_policy(fitted["file"]).extra["store"]


def test_a_diagnosis_says_what_to_know_and_writes_nothing(recorded: Workspace) -> None:
    told = evastudio.diagnose(recorded, 1)
    assert json.loads(json.dumps(told)) == told | {"delay": json.loads(json.dumps(told["delay"]))}
    assert "You answered about 0.1 s late" in told["sentences"][0]
    assert [finding["name"] for finding in told["findings"] if finding["found"]] == []
    assert "Nothing else was found" in told["sentences"][1]
    undelayed = evastudio.diagnose(recorded, 1, delay="off")
    assert undelayed["delay"]["steps"] == 0
    assert any(finding["name"] == "hidden" for finding in undelayed["findings"])


@pytest.mark.parametrize("delay", ["soon", -0.1, 9.0, float("nan")])
def test_a_delay_that_means_nothing_is_refused(recorded: Workspace, delay: object) -> None:
    with pytest.raises(InvalidInputError, match="'auto', 'off' or seconds"):
        evastudio.fit(recorded, 1, learner="knn", delay=delay, name="no")  # type: ignore[arg-type]


def test_one_take_is_fitted_as_it_is(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    evastudio.record(workspace, "asteroids", "scripted:human", 0.5, seed=4, clock=lambda: 0.0)
    fitted = evastudio.fit(workspace, 1, learner="knn")
    assert fitted["delay_s"] == 0.0
    assert "at least two takes" in fitted["report"][0]
