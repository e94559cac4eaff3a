"""Takes that a program makes over HTTP: they replay, repeat safely and claim nothing."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from evastudio.api.arrays import NPZ, npz
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live.headless import make_scene
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene
from evastudio.world.snapshot import stack

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
SEED = 11


@pytest.fixture
def session(studio: Studio) -> int:
    body = {"scene": "asteroids", "name": "By program"}
    made: int = studio.client.post(f"{API}/sessions", json=body).json()["id"]
    return made


def begin(studio: Studio, session: int, **body: Any) -> dict[str, Any]:
    answer = studio.client.post(f"{API}/sessions/{session}/takes", json={"seed": SEED, **body})
    assert answer.status_code == 201, answer.text
    told: dict[str, Any] = answer.json()
    return told


def post(studio: Studio, path: str, body: Any = None) -> tuple[int, dict[str, Any]]:
    answer = studio.client.post(API + path, json=body)
    return answer.status_code, answer.json()


def flown(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """States and actions of the careful demonstrator, to the world's end."""
    moments, actions = [], []

    def watch(_: Any, snapshot: Any, chosen: Any) -> None:
        moments.append(snapshot)
        actions.append(chosen)

    roll_out(scene, find_pilot("scripted:careful"), [seed], watcher=watch)
    states = scene.perception().perceive(stack(moments)).states
    return states, np.concatenate(actions)


def test_a_program_s_take_replays_and_its_outcome_is_computed(
    studio: Studio, session: int, asteroids: Callable[..., Scene]
) -> None:
    scene = asteroids()
    states, actions = flown(scene, SEED)
    take = begin(studio, session, pilot="robot")
    assert take["state"] == states[0].tolist()
    at = take["take"]
    first = {"first_step": 0, "actions": actions[:7].tolist(), "states": states[:7].tolist()}
    status, told = post(studio, f"/takes/{at}/actions", first)
    assert (status, told["pairs"], told["accepted"], told["closed"]) == (200, 7, 7, False)
    assert told["state"] == states[7].tolist()
    rest = np.concatenate([actions[7:], np.zeros((5, 2))])  # the world ends before these
    arrays = {"first_step": np.array(7), "actions": rest, "states": states[7:]}
    answer = studio.client.post(
        f"{API}/takes/{at}/actions", content=npz(arrays), headers={"Content-Type": NPZ}
    )
    assert answer.json()["pairs"] == len(actions)
    assert answer.json()["accepted"] == len(actions) - 7
    assert answer.json()["outcome"] == "crossed"
    assert post(studio, f"/takes/{at}/close")[1]["outcome"] == "crossed"
    with Store(studio.workspace.store_url) as store:
        record, data = store.take(at), store.load_take(at)
        replayed = replay_take(scene, record, data)
    assert (record.pilot, record.outcome) == ("program:robot", "crossed")
    assert np.array_equal(data.states, states)
    for name, array in data.snapshots.moving.items():
        assert np.array_equal(array, replayed.moving[name])


def test_the_same_actions_may_come_again_and_others_not(studio: Studio, session: int) -> None:
    at = begin(studio, session)["take"]
    path = f"/takes/{at}/actions"
    row = [0.05, 0.0]
    assert post(studio, path, {"first_step": 0, "actions": [row] * 6})[0] == 200
    assert post(studio, path, {"first_step": 0, "actions": [row] * 6})[1]["pairs"] == 6
    assert post(studio, path, {"first_step": 2, "actions": [row] * 3})[1]["accepted"] == 3
    for body, says in (
        ({"first_step": 7, "actions": [row]}, "send what follows step 5 first"),
        ({"first_step": 0, "actions": [[0.0, 0.0]] * 6}, "with other actions"),
        ({"first_step": 4, "actions": [row] * 3}, "with other actions"),
    ):
        status, told = post(studio, path, body)
        assert status == 409
        assert says in told["detail"]
    assert post(studio, path, {"first_step": 6, "actions": [row]})[1]["pairs"] == 7
    told = post(studio, f"/takes/{at}/close")[1]
    assert (told["closed"], told["outcome"]) == (True, None)
    status, told = post(studio, path, {"first_step": 7, "actions": [row]})
    assert (status, "is closed" in told["detail"]) == (409, True)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ({"first_step": 0, "actions": [[1.0]]}, "expected (rows, 2)"),
        ({"first_step": 0, "actions": [[1.0, 0.0], [1.0]]}, "differ in length"),
        ({"first_step": 0, "actions": []}, "actions"),
        ({"first_step": -1, "actions": [[0.0, 0.0]]}, "first_step"),
        ({"first_step": 0, "actions": [[0.0, 0.0]], "states": [[0.0]]}, "states"),
        ({"first_step": 0}, "actions: Field required"),
        (
            {"first_step": 0, "actions": [[0.0, 0.0]] * 4097},
            "actions: there are 4097; send at most 4096 at once",
        ),
        ({"first_step": 0, "actions": [[0.0, 0.0], ["x", 0.0]]}, "actions.1.0: Input should be"),
        ([], "body"),
    ],
)
def test_actions_that_cannot_be_are_refused_and_nothing_is_written(
    studio: Studio, session: int, body: Any, says: str
) -> None:
    at = begin(studio, session)["take"]
    status, told = post(studio, f"/takes/{at}/actions", body)
    assert status == 422
    assert says in told["detail"]
    assert "[" not in told["detail"], "places in the body, not the library's names of types"
    assert studio.client.get(f"{API}/takes/{at}").json()["pairs"] == 0


def test_a_program_that_saw_another_world_is_told_so(studio: Studio, session: int) -> None:
    told = begin(studio, session)
    wrong = [value + 0.01 for value in told["state"]]
    body = {"first_step": 0, "actions": [[0.0, 0.0]], "states": [wrong]}
    status, answer = post(studio, f"/takes/{told['take']}/actions", body)
    assert status == 422
    assert "saw another world" in answer["detail"]


def test_a_crowd_s_take_is_led_or_acted_by_all(studio: Studio) -> None:
    made = post(studio, "/sessions", {"scene": "crowd", "name": "Many"})[1]
    scene = make_scene(studio.workspace, "crowd")
    lead = begin(studio, made["id"])["take"]
    size = scene.action.size
    body = {"first_step": 0, "actions": [[1.0] * size] * 2}
    assert post(studio, f"/takes/{lead}/actions", body)[0] == 200
    everybody = np.zeros((3, *scene.characters, size))
    everybody[..., 0] = 1.0
    every = begin(studio, made["id"])["take"]
    body = {"first_step": 0, "actions": everybody.tolist()}
    assert post(studio, f"/takes/{every}/actions", body)[1]["pairs"] == 3
    with Store(studio.workspace.store_url) as store:
        for take in (lead, every):
            record, data = store.take(take), store.load_take(take)
            replayed = replay_take(scene, record, data)
            for name, array in data.snapshots.moving.items():
                assert np.array_equal(array, replayed.moving[name])


def test_a_take_is_downloaded_and_known_by_its_etag(studio: Studio, session: int) -> None:
    at = begin(studio, session)["take"]
    post(studio, f"/takes/{at}/actions", {"first_step": 0, "actions": [[0.05, 0.0]] * 4})
    url = f"{API}/takes/{at}/recording"
    plain = studio.client.get(url)
    arrays = studio.client.get(url, params={"format": "npz"})
    assert arrays.headers["content-type"] == NPZ
    with np.load(io.BytesIO(arrays.content), allow_pickle=False) as loaded:
        assert loaded["states"].tolist() == plain.json()["states"]
        assert loaded["actions"].tolist() == plain.json()["actions"] == [[0.05, 0.0]] * 4
        assert len(loaded["moving.position"]) == 4
    tag = plain.headers["etag"]
    assert tag != arrays.headers["etag"]
    again = studio.client.get(url, headers={"If-None-Match": f'"x", W/{tag}'})
    assert (again.status_code, again.content) == (304, b"")
    post(studio, f"/takes/{at}/actions", {"first_step": 4, "actions": [[0.05, 0.0]]})
    assert studio.client.get(url, headers={"If-None-Match": tag}).status_code == 200


def test_the_trash_is_emptied_on_demand_alone(studio: Studio, session: int) -> None:
    kept, thrown = (begin(studio, session)["take"] for _ in range(2))
    assert post(studio, f"/takes/{thrown}/trash")[1]["trashed"]
    status, told = post(
        studio, f"/takes/{thrown}/actions", {"first_step": 0, "actions": [[0.0, 0.0]]}
    )
    assert (status, "in the trash" in told["detail"]) == (409, True)
    answer = studio.client.delete(f"{API}/sessions/{session}/trash")
    assert answer.json() == {"takes": 1}
    assert studio.client.get(f"{API}/takes/{thrown}").status_code == 404
    assert studio.client.get(f"{API}/takes/{kept}").status_code == 200


@pytest.mark.parametrize("kind", ["text/plain", "application/octet-stream"])
def test_a_body_of_another_kind_is_refused(studio: Studio, session: int, kind: str) -> None:
    at = begin(studio, session)["take"]
    answer = studio.client.post(
        f"{API}/takes/{at}/actions",
        content=json.dumps({"first_step": 0, "actions": [[0.0, 0.0]]}),
        headers={"Content-Type": kind},
    )
    assert answer.status_code == 415
    assert NPZ in answer.json()["detail"]


def test_a_note_is_kept_with_a_take(studio: Studio, session: int) -> None:
    at = begin(studio, session)["take"]
    answer = studio.client.put(f"{API}/takes/{at}/note", json={"note": " Too late at the rock. "})
    assert answer.json()["note"] == "Too late at the rock."
    assert studio.client.get(f"{API}/takes/{at}").json()["note"] == "Too late at the rock."
    assert studio.client.put(f"{API}/takes/{10**6}/note", json={"note": ""}).status_code == 404
