"""Making switches: written, learned from a session, listed, played, and refused in a sentence."""

from __future__ import annotations

import json

import pytest

import evastudio
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError, StorageError
from evastudio.learning.catalog import find_policy_file, list_policies
from evastudio.learning.switch import load_switch
from evastudio.live.piloting import cannot_play, load_pilot
from evastudio.live.switching import marked_takes, parse_entry
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
SMALL = {"people": 8.0, "side": 12.0}


def test_a_switch_is_learned_from_a_marked_session_and_plays(workspace) -> None:
    """Four scripted takes in which the impact is marked, and nothing says that it matters."""
    evastudio.record(
        workspace,
        "crowd",
        "scripted:surprised",
        minutes=2.0,
        options=SMALL,
        session="marked by rule",
        mark="event:impact",
    )
    entries = [("crowd-fleeing", "learned:marked by rule"), ("crowd-hurried", None)]
    made = evastudio.switch(workspace, "mine", entries)
    assert "once the boulder has hit the ground" in made["report"][0]
    assert "Learned from" in made["report"][1]
    path = find_policy_file("mine", workspace.policy_folders)
    switch = load_switch(path)
    assert switch.made_by.startswith("evastudio record crowd")
    assert "--mark event:impact" in switch.made_by
    assert switch.entries[0].learned["marks"] >= 3
    entry = list_policies(workspace.policy_folders)["mine"]
    assert entry.switch == switch
    assert entry.problem is None
    with Store(workspace.store_url) as store:
        takes = marked_takes(workspace, store, store.session("marked by rule"), "boulder")
    assert takes.names[-2].startswith("boulder.")
    result = evastudio.evaluate(workspace, ["mine"], worlds=2)
    assert result["scene"]["name"] == "crowd"
    assert result["policies"]["mine"]["outcomes"]["over"] == 2


def test_entries_are_written_as_they_are_said() -> None:
    assert parse_entry("a when event:impact") == ("a", "event:impact")
    assert parse_entry("a once x<3 and y<2") == ("a", "once x<3 and y<2")
    assert parse_entry("a when learned:my when session") == ("a", "learned:my when session")
    assert parse_entry(" a ") == ("a", None)


def test_what_cannot_be_made_is_refused_in_a_sentence(workspace) -> None:
    hurried = ("crowd-hurried", None)
    for entries, error, says in (
        (
            [("crowd-fleeing", "event:rain"), hurried],
            NotFoundError,
            "no sign 'rain' of scene 'crowd'",
        ),
        ([("crowd-flying", "after:1s"), hurried], NotFoundError, "no policy 'crowd-flying'"),
        ([("asteroids-careful", "after:1s"), hurried], ConflictError, "Entry 2"),
        ([hurried], InvalidInputError, "needs 2 to 16"),
        ([("crowd-fleeing", "learned:nobody"), hurried], NotFoundError, "no session 'nobody'"),
    ):
        with pytest.raises(error, match=says):
            evastudio.switch(workspace, "mine", entries)
    sound = [("crowd-fleeing", "event:impact"), hurried]
    with pytest.raises(ConflictError, match="There is a policy 'crowd-hurried'"):
        evastudio.switch(workspace, "crowd-hurried", sound)
    with pytest.raises(InvalidInputError, match=r"ends in \.switch\.json"):
        evastudio.switch(workspace, "mine", sound, out="mine.json")
    evastudio.record(workspace, "crowd", "scripted:hurried", 0.1, options=SMALL, session="plain")
    with pytest.raises(InvalidInputError, match="No moment is marked"):
        evastudio.switch(workspace, "mine", [("crowd-fleeing", "learned:plain"), hurried])
    assert list(workspace.policies.iterdir()) == []


def test_a_switch_whose_policy_is_gone_says_so(workspace) -> None:
    scene = CROWD(**SMALL)
    made = evastudio.switch(
        workspace, "mine", [("crowd-fleeing", "event:impact"), ("crowd-hurried", None)]
    )
    switch = load_switch(made["file"])
    known = list_policies(workspace.policy_folders)
    assert cannot_play(switch, scene, known) is None
    fewer = {name: entry for name, entry in known.items() if name != "crowd-hurried"}
    assert "'crowd-hurried', which is not here" in cannot_play(switch, scene, fewer)
    text = (workspace.policies / "mine.switch.json").read_text()
    (workspace.policies / "mine.switch.json").write_text(text.replace("hurried", "gone"))
    with pytest.raises(NotFoundError, match=r"Entry 2 of switch 'mine'.*'crowd-gone'"):
        load_pilot(workspace, "mine", scene)
    (workspace.policies / "mine.switch.json").write_text(text.replace('"impact"', '"rain"'))
    with pytest.raises(ConflictError, match="looks at 'rain'"):
        load_pilot(workspace, "mine", scene)
    assert "looks at 'rain'" in cannot_play(
        load_switch(made["file"]), scene, list_policies(workspace.policy_folders)
    )


@pytest.mark.parametrize(
    ("policy", "says"),
    [("mine", "'mine' is itself a switch"), ("guarded:scripted:nobody", "'scripted:nobody'")],
)
def test_a_switch_that_names_no_policy_is_listed_with_the_reason(workspace, policy, says) -> None:
    entries = [("crowd-fleeing", "event:impact"), ("crowd-hurried", None)]
    path = workspace.policies / "mine.switch.json"
    evastudio.switch(workspace, "mine", entries)
    path.write_text(path.read_text().replace('"crowd-hurried"', json.dumps(policy)))
    known = list_policies(workspace.policy_folders)
    assert says in cannot_play(load_switch(path), CROWD(**SMALL), known)


def test_a_session_of_another_version_of_the_scene_tells_no_switch(workspace) -> None:
    class Older(CROWD):
        version = CROWD.version - 1

    with Store(workspace.ready().store_url) as store:
        store.create_session(Older(**SMALL), "old", "person", 0.0)
    entries = [("crowd-fleeing", "learned:old"), ("crowd-hurried", None)]
    with pytest.raises(ConflictError, match=f"version {Older.version} of the scene"):
        evastudio.switch(workspace, "mine", entries)


def test_damaged_switches_are_refused_whatever_is_wrong(workspace) -> None:
    path = workspace.policies / "crowd.switch.json"
    whole = json.loads((shipped() / "policies" / "crowd-and-boulder.switch.json").read_text())
    text = json.dumps(whole)
    broken = [text[:size] for size in range(0, len(text), 23)]
    for keys, value in (
        (("format",), 2),
        (("scene", "version"), "1"),
        (("scene", "name"), 7),
        (("entries",), {}),
        (("entries",), whole["entries"] * 9),
        (("entries", 0, "policy"), None),
        (("entries", 0, "learned"), 3),
        (("entries", 0, "when"), None),
        (("entries", 1, "when"), whole["entries"][0]["when"]),
        (("entries", 0, "when", "once"), 1),
        (("entries", 0, "when", "bounds"), []),
        (("entries", 0, "when", "bounds", 0, "low"), float("nan")),
        (("entries", 0, "when", "bounds", 0, "low"), 10**400),
        (("entries", 0, "when", "bounds", 0, "low"), True),
        (("entries", 0, "when", "bounds", 0, "reading"), 3),
        (("made_by",), None),
        (("entries", 0, "policy"), "half a letter: \ud800"),
        (("entries", 0, "learned"), {"near": float("nan")}),
    ):
        spoilt = json.loads(text)
        place = spoilt
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = value
        broken.append(json.dumps(spoilt))
    broken += ["[" * 100_000, '"' + "x" * 1_000_001 + '"', "[]", "null"]
    for one in broken:
        path.write_text(one)
        with pytest.raises(StorageError, match="not a switch that can be used"):
            load_switch(path)
        assert list_policies(workspace.policy_folders)["crowd"].problem is not None
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StorageError, match="not a switch that can be used"):
        load_switch(path)
