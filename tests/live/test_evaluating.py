"""Evaluations by name, kept and made again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from sqlalchemy import update

import evastudio
from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.evaluation.versions import versions
from evastudio.workspace import Workspace

OPTIONS = {"density": 3.0}
OWN = """
from evastudio.world.loading import load_scene_file
from evastudio.workspace import shipped


class Own(load_scene_file(shipped() / "scenes" / "asteroids.py")):
    name, version = "own", {version}


SCENE = Own
"""


def test_an_evaluation_is_kept_and_repeats_bit_for_bit(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    told = evastudio.evaluate(
        workspace,
        ["asteroids-careful", "scripted:human"],
        worlds=6,
        seed=9,
        options=OPTIONS,
        like="scripted:human",
        clock=lambda: 5.0,
    )
    (kept,) = evastudio.evaluations(workspace)
    assert kept["id"] == told["evaluation"]
    assert kept["created_at"] == 5.0
    assert kept["result"]["pilots"] == told["policies"]
    assert kept["asked"]["policies"]["scripted:human"] is None
    assert len(kept["asked"]["policies"]["asteroids-careful"]) == 64
    again = evastudio.repeat_evaluation(workspace, told["evaluation"], jobs=2)
    assert again == {"evaluation": told["evaluation"], "same": True, "differs": [], "changed": []}
    assert len(evastudio.evaluations(workspace)) == 1


def test_a_policy_that_was_fitted_anew_since_is_named(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    evastudio.record(workspace, "asteroids", "scripted:careful", 0.5, seed=1)
    evastudio.fit(workspace, 1, learner="knn", name="mine", clock=lambda: 0.0)
    number = evastudio.evaluate(workspace, ["mine"], worlds=5, options=OPTIONS)["evaluation"]
    evastudio.fit(workspace, 1, learner="knn", settings={"k": 1}, name="mine", clock=lambda: 0.0)
    again = evastudio.repeat_evaluation(workspace, number)
    assert again["changed"] == ["policy mine"]
    assert not again["same"]
    assert "mine: turn" in again["differs"]


def test_a_scene_and_packages_that_are_others_since_are_named(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    own = tmp_path / "scenes" / "own.py"
    own.parent.mkdir()
    own.write_text(OWN.format(version=3), encoding="utf-8")
    number = evastudio.evaluate(workspace, ["straight"], scene="own", worlds=2)["evaluation"]
    assert evastudio.repeat_evaluation(workspace, number)["changed"] == []
    own.write_text(OWN.format(version=4), encoding="utf-8")
    then = {**versions(), "evastudio": "0.0.1", "numpy": "1.0"}
    with Store(workspace.store_url) as store, writing(store.engine) as connection:
        connection.execute(update(schema.evaluations).values(versions=json.dumps(then)))
    again = evastudio.repeat_evaluation(workspace, number)
    assert again["changed"] == [
        f"evastudio 0.0.1, now {versions()['evastudio']}",
        f"numpy 1.0, now {versions()['numpy']}",
        "scene 3, now 4",
    ]
    assert again["same"], "what changed need not change a figure"


def test_what_cannot_be_evaluated_is_told(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    with pytest.raises(InvalidInputError, match="No policy"):
        evastudio.evaluate(workspace, [])
    with pytest.raises(NotFoundError, match="nobody"):
        evastudio.evaluate(workspace, ["scripted:careful"], worlds=2, like="nobody")
    with pytest.raises(NotFoundError, match="no evaluation 7"):
        evastudio.repeat_evaluation(workspace, 7)
    assert evastudio.evaluations(workspace) == []


def test_pilots_are_compared_with_the_takes_of_a_session(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    evastudio.record(
        workspace, "asteroids", "scripted:careful", 1.5, seed=1, options=OPTIONS, session="Calm"
    )
    told = evastudio.evaluate(
        workspace,
        ["scripted:careful", "straight"],
        worlds=8,
        seed=9,
        options=OPTIONS,
        like_session="Calm",
    )
    assert told["like"] == "the takes of “Calm”"
    unlike = {name: one["unlike"] for name, one in told["policies"].items()}
    assert unlike["scripted:careful"] < 0.03 < 0.1 < unlike["straight"]
    assert told["says"][-1].startswith("How they move differs from the takes of “Calm”: ")
    with Store(workspace.store_url) as store:
        (first, *_) = store.takes(1)
        store.trash_take(first.id, 0.0)
    again = evastudio.repeat_evaluation(workspace, told["evaluation"])
    assert again["same"], "it is made again from the takes it was made from"
    with pytest.raises(ConflictError, match="of scene 'asteroids', and this is 'crowd'"):
        evastudio.evaluate(workspace, ["crowd-shy"], worlds=2, like_session=1)
    with pytest.raises(InvalidInputError, match="choose one"):
        evastudio.evaluate(workspace, ["straight"], worlds=2, like_session=1, like="straight")
