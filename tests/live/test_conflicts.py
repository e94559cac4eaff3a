"""Conflicts before cleaning: at any threshold, judged one by one, and shown in the scene."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import evastudio
from evastudio.demonstrations.by_hand import mark_by_hand
from evastudio.demonstrations.packing import pack, unpack
from evastudio.demonstrations.records import SessionRecord, Verdict
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.learning.cleaning import clean_pairs
from evastudio.learning.policy_files import load_policy
from evastudio.live import cleaning, headless
from evastudio.live.age import made_before
from evastudio.live.conflicts import Conflicts, find_conflicts
from evastudio.live.live_stage import LiveStage
from evastudio.live.missing import missing_words
from evastudio.live.perceiving import see_session
from evastudio.live.picture import Picture
from evastudio.live.sketch import FAMILIAR, STRANGE
from evastudio.live.stages import Stages
from evastudio.live.weighing import compared, weigh
from evastudio.workspace import Workspace

BOTH = ("canonical", "paper")


@pytest.fixture(scope="module")
def looked(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A workspace with session 1 of a scripted human, in which conflicts were looked for."""
    workspace = Workspace(tmp_path_factory.mktemp("looked"))
    evastudio.record(workspace, "asteroids", "scripted:human", 1.5, seed=4, clock=lambda: 0.0)
    cleaning.preview(workspace, 1, delay=0.2)
    return workspace


@pytest.fixture
def workspace(looked: Workspace, tmp_path: Path) -> Workspace:
    """A copy of it, to be changed."""
    shutil.copytree(looked.root, tmp_path / "own")
    return Workspace(tmp_path / "own")


@pytest.fixture
def store(workspace: Workspace) -> Iterator[Store]:
    with Store(workspace.store_url) as store:
        yield store


def found(workspace: Workspace, store: Store) -> tuple[SessionRecord, Conflicts]:
    session = store.session(1)
    return session, find_conflicts(workspace, store.identity, session)


@pytest.mark.parametrize("threshold", ["auto", 0.3])
def test_what_would_go_is_what_cleaning_takes_out(
    workspace: Workspace, store: Store, threshold: float | str
) -> None:
    session, _ = found(workspace, store)
    before = weigh(workspace, store, session, threshold, 1000)
    assert 0 < before.goes == before.conflicts == len(before.items) < before.pairs
    off = [one.deviation - one.limit for one in before.items]
    assert off == sorted(off, reverse=True)
    done = cleaning.clean(workspace, 1, threshold=threshold, delay=0.2)
    assert done["removed"] == before.goes
    marks = store.marks(1)
    assert all(marks[one.take][one.step] for one in before.items)
    assert json.dumps(before.items[0].says)


def test_a_lower_threshold_lets_more_go_and_none_is_refused(
    workspace: Workspace, store: Store
) -> None:
    session, _ = found(workspace, store)
    goes = [weigh(workspace, store, session, at, 0).goes for at in (1.4, 0.5, 0.2, 0.05)]
    assert goes == sorted(goes)
    assert goes[0] < goes[-1]
    for wrong in (0.0, -1.0, float("nan"), "loose"):
        with pytest.raises(InvalidInputError, match="threshold"):
            weigh(workspace, store, session, wrong)


def test_what_is_said_of_pairs_counts_for_more_than_how_far_off_they_are(
    workspace: Workspace, store: Store
) -> None:
    session, conflicts = found(workspace, store)
    before = weigh(workspace, store, session, most=1000)
    meant, unseen, *_ = before.items
    calm = int(np.flatnonzero(~conflicts.marked("auto"))[100])
    slip = int(conflicts.takes[calm]), int(conflicts.steps[calm])
    store.judge(meant.take, meant.step, Verdict.KEEP)
    store.judge(unseen.take, unseen.step, Verdict.MISSING)
    store.judge(*slip, Verdict.DELETE)
    after = weigh(workspace, store, session, most=1000)
    assert (after.conflicts, after.goes) == (before.conflicts, before.goes - 1)
    judged = {(one.take, one.step): (one.conflict, one.goes) for one in after.items if one.verdict}
    assert judged == {
        (meant.take, meant.step): (True, False),
        (unseen.take, unseen.step): (True, False),
        slip: (False, True),
    }
    cleaning.clean(workspace, 1, delay=0.2)
    marks = store.marks(1)
    assert not marks[meant.take][meant.step]
    assert not marks[unseen.take][unseen.step]
    assert marks[slip[0]][slip[1]]
    assert sum(int(mask.sum()) for mask in marks.values()) == after.goes
    settings = store.session(1).cleaning
    assert settings is not None
    assert (settings.settings["kept_by_hand"], settings.settings["deleted_by_hand"]) == (2, 1)
    assert store.undo_cleaning(1)
    assert store.marks(1) == {}

    # What is missing is said where it matters: in the report of what was fitted.
    headless.fit(workspace, 1, learner="knn", delay="off", name="told")
    report = load_policy(workspace.policies / "told.safetensors").extra["findings"]
    assert "Of 1 moment you said that something is missing" in report[0]


def test_a_perception_that_has_what_is_missing_is_named(workspace: Workspace, store: Store) -> None:
    session = store.session(1)
    views = {view.perception.name: view for view in see_session(workspace, store, session, BOTH)}
    off = {
        name: clean_pairs(view.pairs(3), view.scene, name).deviations
        for name, view in views.items()
    }
    pairs = views["canonical"].pairs(3)

    def words(perception: str, rows: list[int]) -> str:
        moments = {(int(pairs.takes[row]), int(pairs.steps[row])): Verdict.MISSING for row in rows}
        (told,) = missing_words(workspace, session, views[perception], 3, moments)
        return told

    solved = np.flatnonzero(off["paper"] < 0.5 * off["canonical"])[:3].tolist()
    alike = abs(np.log(off["paper"] / off["canonical"])) < 0.1
    unsolved = np.flatnonzero(alike)[:3].tolist()
    assert "Of 3 moments" in words("canonical", solved)
    assert "The perception 'paper' tells 3 of them apart" in words("canonical", solved)
    assert "'paper' tells 3 of them apart" in words("canonical", [*solved, *unsolved])
    assert "No other perception at hand tells them apart" in words("canonical", unsolved)
    assert "'paper', fitted here, tells 3 of them apart" in words("paper", solved)
    assert missing_words(workspace, session, views["canonical"], 3, {(1, 1): Verdict.KEEP}) == []


def test_a_pair_is_told_beside_those_that_it_was_compared_with(
    workspace: Workspace, store: Store
) -> None:
    session, conflicts = found(workspace, store)
    first = weigh(workspace, store, session, most=1).items[0]
    told = compared(workspace, store, session, first.take, first.step)
    assert told.conflict == first
    assert len(told.neighbors) == conflicts.about.n_neighbors
    assert (first.take, first.step) not in {(one.take, one.step) for one in told.neighbors}
    for take, step in ((first.take, 10**9), (10**30, 0), (999, 0)):
        with pytest.raises(NotFoundError, match="was not compared"):
            compared(workspace, store, session, take, step)


def test_other_takes_than_those_looked_at_are_told(workspace: Workspace, store: Store) -> None:
    session, _ = found(workspace, store)
    before = weigh(workspace, store, session, most=1000)
    gone = before.items[0].take
    pairs = store.take(gone).pairs
    store.trash_take(gone, 1.0)
    after = weigh(workspace, store, session, most=1000)
    assert (before.stale, after.stale) == (False, True)
    assert before.pairs - pairs <= after.pairs < before.pairs
    assert gone not in {one.take for one in after.items}


def test_nobody_has_looked_in_another_store_or_at_all(workspace: Workspace, store: Store) -> None:
    session, _ = found(workspace, store)
    with pytest.raises(NotFoundError, match="Look first"):
        find_conflicts(workspace, "another store", session)
    (path,) = workspace.conflicts.iterdir()
    path.unlink()
    with pytest.raises(NotFoundError, match="Look first"):
        find_conflicts(workspace, store.identity, session)


def test_a_file_of_conflicts_that_was_changed_counts_as_none(
    workspace: Workspace, store: Store
) -> None:
    session, whole = found(workspace, store)
    (path,) = workspace.conflicts.iterdir()
    data, arrays = path.read_bytes(), unpack(path.read_bytes(), "file")
    told = json.loads(arrays["about"].tobytes())

    def with_about(**changed: object) -> bytes:
        text = json.dumps({**told, **changed}).encode()
        return pack({**arrays, "about": np.frombuffer(text, dtype=np.uint8)})

    beyond = np.full_like(whole.neighbors, len(whole.takes))
    for changed in (
        data[:1000],
        b"",
        pack({**arrays, "steps": whole.steps[:-1]}),
        pack({**arrays, "actions": whole.actions[:, :1]}),
        pack({**arrays, "takes": whole.takes.astype(np.float64)}),
        pack({**arrays, "neighbors": beyond}),
        pack({**arrays, "neighbors": -1 - whole.neighbors}),
        pack({**arrays, "more": whole.steps}),
        pack({name: array for name, array in arrays.items() if name != "limits"}),
        with_about(names=["theta"]),
        with_about(span=[]),
        with_about(seen=[1, 2]),
        with_about(n_neighbors=3),
        with_about(more=1),
        pack({**arrays, "about": np.frombuffer(b"[" * 9, dtype=np.uint8)}),
    ):
        path.write_bytes(changed)
        with pytest.raises(NotFoundError, match="Look first"):
            find_conflicts(workspace, store.identity, session)


def test_a_conflict_is_shown_with_where_its_neighbours_actions_lead(
    workspace: Workspace, store: Store
) -> None:
    session, conflicts = found(workspace, store)
    first = weigh(workspace, store, session, most=1).items[0]
    stages = Stages(workspace, store)
    stage: LiveStage = stages.open("asteroids", {}, seed=4)
    shown: list[Picture] = []
    stage.watch(shown.append)
    stage.looking_back.compare(first.take, first.step)
    status = stage.status()
    assert (status["mode"], status["take"]) == ("review", first.take)
    assert status["position_s"] == pytest.approx(first.seconds)
    stage.watch(picture := [].append)  # type: ignore[attr-defined]
    stage.unwatch(picture)
    ways = [line for line in shown[-1].lines if line.name.startswith("way")]
    assert len(ways) == conflicts.about.n_neighbors + 1
    assert [tuple(way.colors[0]) for way in (ways[0], ways[-1])] == [FAMILIAR, STRANGE]
    start = ways[0].points[0]
    assert all(np.allclose(way.points[0], start) for way in ways)
    assert np.linalg.norm(ways[-1].points[15] - start) > 1.0

    # They belong to that moment.
    stage.looking_back.seek(first.seconds + 1.0)
    stage.watch(picture := [].append)  # type: ignore[attr-defined]
    assert not [line for line in shown[-1].lines if line.name.startswith("way")]
    with pytest.raises(NotFoundError, match="was not compared"):
        stage.looking_back.compare(first.take, 10**6)
    lost = replace(conflicts, about=replace(conflicts.about, perception="gone"))
    lost.save(workspace)
    with pytest.raises(NotFoundError, match="no perception 'gone'"):
        stage.looking_back.compare(first.take, first.step)
    stages.close_all()


def test_a_policy_says_what_it_was_made_before(workspace: Workspace, store: Store) -> None:
    headless.fit(workspace, 1, learner="knn", delay="off", name="old")
    policy = load_policy(workspace.policies / "old.safetensors")
    header = {
        "session": policy.session,
        "takes": list(policy.takes),
        "cleaning": policy.cleaning,
        "extra": policy.extra,
    }
    first, second, *_ = (take.id for take in store.takes(1))
    assert made_before(header, store) is None
    store.trash_take(first, 1.0)
    assert made_before(header, store) == "made before 1 take was thrown away"
    store.trash_take(second, 1.0)
    assert made_before(header, store) == "made before 2 takes were thrown away"
    fewer = {**header, "takes": list(policy.takes)[2:]}
    store.restore_take(first)
    store.restore_take(second)
    assert made_before(fewer, store) == "made before 2 takes were added"
    mark_by_hand(store, first, 4, True, 2.0)
    assert made_before(header, store) == "made before 1 moment was left out by hand"
    headless.fit(workspace, 1, learner="knn", delay="off", name="by-hand")
    store.undo_cleaning(1)
    cleaning.clean(workspace, 1)
    assert made_before(header, store) == "made before the takes were cleaned"
    elsewhere = {**header, "extra": {**policy.extra, "store": "another"}}
    assert made_before(elsewhere, store) is None
    assert made_before({**header, "session": 99}, store) == "made before its session was deleted"
