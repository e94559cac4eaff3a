"""Recordings of people become takes that replay and can be learned from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import evastudio
from evastudio.demonstrations.pairs import perceive_take
from evastudio.demonstrations.records import RECORDED
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.learning.policy_files import load_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import Workspace, shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out

STREET = load_scene_file(shipped() / "scenes" / "street.py")


PEOPLE = 12


@pytest.fixture(scope="module")
def walked() -> np.ndarray:
    """Where scripted people were on the way to their first goals, (steps, PEOPLE, 2), else NaN."""
    scene = STREET(people=PEOPLE, size=12)
    moment, places = scene.worlds([3]), []
    for _ in range(40):
        going = moment["leg"][0] == 0
        places.append(np.where(going[:, None], moment["position"][0], np.nan))
        moment = scene.step(moment, scene.intention(moment))
    return np.array(places)


@pytest.fixture
def recording(tmp_path: Path, walked: np.ndarray) -> Path:
    """The same as a table; the people are numbered from 100 on."""
    lines = ["# source=drawn.txt fps=5 ; Nobody, scripted"]
    for step, places in enumerate(walked):
        lines += [
            f"{2 * step} {100 + person} {x:.4f} {y:.4f}"
            for person, (x, y) in enumerate(places)
            if x == x
        ]
    path = tmp_path / "drawn.txt"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_an_imported_take_replays_bit_for_bit(workspace: Workspace, recording: Path) -> None:
    made = evastudio.import_walks(workspace, [recording], people=5)
    assert made["takes"] == 5
    assert made["demonstrator"] == "people: Nobody, scripted"
    with Store(workspace.store_url) as store:
        for take in store.takes(made["session"]):
            assert (take.seed, take.outcome) == (RECORDED, "arrived")
            assert take.pilot == "people: drawn.txt, Nobody, scripted"
            data = store.load_take(take.id)
            again = replay_take(STREET(**take.options), take, data)
            for name, array in data.snapshots.moving.items():
                np.testing.assert_array_equal(array, again[name])


def test_people_are_where_they_were_recorded(
    workspace: Workspace, recording: Path, walked: np.ndarray
) -> None:
    made = evastudio.import_walks(workspace, [recording], people=100)
    assert made["takes"] == PEOPLE
    with Store(workspace.store_url) as store:
        for take in store.takes(made["session"]):
            data = store.load_take(take.id)
            lead = data.snapshots["position"][:, 0]
            whom = int(np.argmin(np.abs(walked[1] - lead[0]).sum(axis=1)))
            np.testing.assert_allclose(lead, walked[1 : len(lead) + 1, whom], atol=1e-3)
            assert data.snapshots["present"].sum(axis=1).max() > 5
            view = STREET().perceptions["goal"]
            pairs = perceive_take(view, data.snapshots, data.actions, take.id)
            change = np.diff(data.snapshots["velocity"][:, 0], axis=0)
            felt = np.hypot(*pairs.actions[:-1].T)
            np.testing.assert_allclose(felt, np.hypot(*change.T), atol=1e-9)


def test_a_policy_learns_to_walk_as_people_did(workspace: Workspace, recording: Path) -> None:
    evastudio.import_walks(workspace, [recording], session="Drawn")
    fitted = evastudio.fit(workspace, "Drawn", name="drawn")
    scene = STREET(people=6, size=12)
    pilot = PolicyPilot(load_policy(Path(fitted["file"])), "drawn")
    rolled = roll_out(scene, pilot, [1, 2, 3])
    assert (rolled.outcomes == 1).all()


@pytest.mark.parametrize(
    ("scene", "people", "error", "says"),
    [
        ("crowd", 5, NotFoundError, "In scene 'crowd' nobody can walk"),
        ("streat", 5, NotFoundError, "Did you mean 'street'"),
        ("street", 0, InvalidInputError, "at least 1"),
    ],
)
def test_what_cannot_be_imported_leaves_no_session(
    workspace: Workspace,
    recording: Path,
    scene: str,
    people: int,
    error: type[Exception],
    says: str,
) -> None:
    with pytest.raises(error, match=says):
        evastudio.import_walks(workspace, [recording], scene=scene, people=people)
    assert evastudio.sessions(workspace) == []


def test_people_who_stand_about_lead_no_take(workspace: Workspace, tmp_path: Path) -> None:
    path = tmp_path / "standing.txt"
    path.write_text("# fps=1\n" + "".join(f"{step} 1 0 0\n" for step in range(30)))
    with pytest.raises(InvalidInputError, match="is seen to go anywhere"):
        evastudio.import_walks(workspace, [path])
    path.write_text("# fps=1\n0 1 0 0\n")
    with pytest.raises(InvalidInputError, match="shows nobody for as long"):
        evastudio.import_walks(workspace, [path])


def test_a_file_is_also_looked_for_among_the_recordings(
    workspace: Workspace, recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("EVASTUDIO_DATA", str(recording.parent))
    assert evastudio.import_walks(workspace, ["drawn.txt"], people=1)["takes"] == 1
