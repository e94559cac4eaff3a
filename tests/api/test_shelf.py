"""Policies over HTTP: asked what they would do and why, taken, put and deleted as files."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from evastudio.api.arrays import NPZ, npz
from evastudio.demonstrations.store import Store
from evastudio.learning.policy_files import load_policy
from evastudio.live import headless
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import shipped
from evastudio.world.scene import Scene
from tests.learning.fitted import rewritten

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
POLICIES = f"{API}/policies"
NAME = "asteroids-careful"
BINARY = {"Content-Type": "application/octet-stream"}
FILE = shipped() / "policies" / f"{NAME}.safetensors"


def states(asteroids: Callable[..., Scene], count: int) -> np.ndarray:
    scene = asteroids()
    return scene.perception().perceive(scene.worlds(range(count))).states


def test_a_policy_decides_for_many_states_as_it_does_in_python(
    studio: Studio, asteroids: Callable[..., Scene]
) -> None:
    asked = states(asteroids, 40)
    expected = load_policy(FILE).act_states(asked)
    url = f"{POLICIES}/{NAME}/decide"
    plain = studio.client.post(url, json={"states": asked.tolist()}).json()
    assert plain["actions"] == expected.tolist()
    assert (len(plain["fields"]), plain["symbols"]) == (2, None)
    answer = studio.client.post(
        url,
        content=npz({"states": asked}),
        params={"format": "npz"},
        headers={"Content-Type": NPZ},
    )
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as arrays:
        assert np.array_equal(arrays["actions"], expected)


def test_a_file_whose_description_makes_no_sense_hides_no_others(studio: Studio) -> None:
    path = studio.workspace.policies / "odd.safetensors"
    with Store(studio.workspace.store_url) as store:
        here = store.identity
    for extra, changed in (
        ({"delay": {"steps": 1}}, {}),
        ({"findings": "text"}, {}),
        ({"store": here}, {"session": float("inf")}),
    ):
        path.write_bytes(FILE.read_bytes())
        rewritten(path, lambda header, new=(extra, changed): header.update(extra=new[0], **new[1]))
        listed = {one["name"]: one for one in studio.client.get(POLICIES).json()["items"]}
        assert "not whole" in listed["odd"]["problem"], (extra, changed)
        assert listed[NAME]["problem"] is None
    path.unlink()


def test_a_policy_decides_at_moments_of_a_take_in_the_world_s_frame(
    studio: Studio, asteroids: Callable[..., Scene]
) -> None:
    session = headless.record(studio.workspace, "asteroids", minutes=0.05, session="Asked")
    take = studio.client.get(f"{API}/sessions/{session['session']}/takes").json()["items"][0]
    body = {"moments": {"take": take["id"], "steps": [3, 0]}}
    told = studio.client.post(f"{POLICIES}/{NAME}/decide", json=body).json()
    scene = asteroids()
    world = scene.worlds([take["seed"]])
    pilot = PolicyPilot(load_policy(FILE))
    assert told["actions"][1] == pilot.act(scene, world, {})[0][0].tolist()
    body["moments"]["steps"] = [10**6]
    answer = studio.client.post(f"{POLICIES}/{NAME}/decide", json=body)
    assert (answer.status_code, "has no step" in answer.json()["detail"]) == (422, True)


def test_a_decision_leads_to_the_moments_it_comes_from(studio: Studio) -> None:
    made = headless.record(studio.workspace, "asteroids", minutes=0.1, session="Sources")
    headless.fit(studio.workspace, made["session"], learner="knn", settings={"k": 3}, name="why")
    take = studio.client.get(f"{API}/sessions/{made['session']}/takes").json()["items"][0]["id"]
    shown = studio.client.get(f"{API}/takes/{take}/recording").json()["states"]
    url = f"{POLICIES}/why/explain"
    told = studio.client.post(url, json={"states": shown[5:7]}).json()
    assert told["session"] == made["session"]
    for number, one in enumerate(told["explanations"]):
        first, *others = one["neighbors"]
        assert (first["take"], first["step"], first["distance"]) == (take, 5 + number, 0.0)
        assert len(others) == 2
        assert one["nearest"] == 0.0
        assert sum(neighbor["weight"] for neighbor in one["neighbors"]) == pytest.approx(1.0)
    assert studio.client.delete(f"{POLICIES}/why").status_code == 204
    assert studio.client.post(url, json={"states": shown[5:7]}).status_code == 404


@pytest.mark.parametrize("file", sorted((shipped() / "policies").glob("*.safetensors")))
def test_every_shipped_policy_decides_and_explains(studio: Studio, file: Any) -> None:
    policy = load_policy(file)
    body = {"states": np.zeros((2, policy.state.size)).tolist()}
    name = file.name.removesuffix(".safetensors")
    for what in ("decide", "explain"):
        answer = studio.client.post(f"{POLICIES}/{name}/{what}", json=body)
        assert answer.status_code == 200, answer.text


@pytest.mark.parametrize(
    ("body", "status", "says"),
    [
        ({"states": [[0.0]]}, 422, "expected (rows,"),
        ({"states": [[0.0], [0.0, 1.0]]}, 422, "differ in length"),
        ({"states": []}, 422, "states"),
        ({}, 422, "either states or moments"),
        ({"states": [[1e300] * 10]}, 422, "states"),
        ({"moments": {"take": 10**6, "steps": [0]}}, 404, "no take"),
    ],
)
def test_a_question_that_cannot_be_answered_is_refused(
    studio: Studio, body: Any, status: int, says: str
) -> None:
    answer = studio.client.post(f"{POLICIES}/{NAME}/decide", json=body)
    assert answer.status_code == status
    assert says in answer.json()["detail"]


def test_a_policy_goes_out_and_comes_in_as_the_same_file(studio: Studio) -> None:
    taken = studio.client.get(f"{POLICIES}/{NAME}/file")
    assert taken.content == FILE.read_bytes()
    tag = taken.headers["etag"]
    url = f"{POLICIES}/came-in/file"
    assert studio.client.get(url).status_code == 404
    put = studio.client.put(url, content=taken.content, headers=BINARY)
    assert (put.status_code, put.json()["name"], put.json()["shipped"]) == (200, "came-in", False)
    same = studio.client.get(url, headers={"If-None-Match": tag})
    assert same.status_code == 304
    again = studio.client.put(url, content=taken.content, headers=BINARY)
    assert (again.status_code, "If-Match" in again.json()["detail"]) == (409, True)
    stale = studio.client.put(url, content=taken.content, headers={**BINARY, "If-Match": '"x"'})
    assert stale.status_code == 412
    meant = studio.client.put(url, content=taken.content, headers={**BINARY, "If-Match": tag})
    assert meant.status_code == 200
    assert studio.client.delete(f"{POLICIES}/came-in", headers={"If-Match": '"x"'}).is_error
    assert studio.client.delete(f"{POLICIES}/came-in").status_code == 204
    assert studio.client.get(f"{POLICIES}/came-in").status_code == 404


def test_a_switch_is_a_file_too_and_keeps_what_it_needs(studio: Studio) -> None:
    taken = studio.client.get(f"{POLICIES}/crowd-and-boulder/file")
    assert taken.headers["content-type"] == "application/json"
    told = json.loads(taken.content)
    file = (shipped() / "policies" / "crowd-fleeing.safetensors").read_bytes()
    assert studio.client.put(f"{POLICIES}/own/file", content=file, headers=BINARY).is_success
    told["entries"][0]["policy"] = "own"
    put = studio.client.put(f"{POLICIES}/own-switch/file", json=told)
    assert (put.status_code, put.json()["switches"][0]) == (200, "own")
    refused = studio.client.delete(f"{POLICIES}/own")
    assert (refused.status_code, "'own-switch'" in refused.json()["detail"]) == (409, True)
    asked = studio.client.post(f"{POLICIES}/own-switch/decide", json={"states": [[0.0]]})
    assert (asked.status_code, "is a switch" in asked.json()["detail"]) == (409, True)
    for name in ("own-switch", "own"):
        assert studio.client.delete(f"{POLICIES}/{name}").status_code == 204


def test_what_is_no_policy_is_not_kept_and_a_shipped_one_stays(studio: Studio) -> None:
    for name, content, headers, status in (
        ("bad", b"nothing of the kind", BINARY, 422),
        ("bad", FILE.read_bytes()[:-9], BINARY, 422),
        ("bad", b"{}", {"Content-Type": "application/json"}, 422),
        ("bad", b"x", {"Content-Type": "text/plain"}, 415),
        ("..%2Fbad", FILE.read_bytes(), BINARY, 404),
        ("Bad", FILE.read_bytes(), BINARY, 422),
    ):
        answer = studio.client.put(f"{POLICIES}/{name}/file", content=content, headers=headers)
        assert answer.status_code == status, answer.text
        assert str(studio.workspace.root) not in answer.text
    assert not list(studio.workspace.root.rglob("*bad*"))
    refused = studio.client.delete(f"{POLICIES}/{NAME}")
    assert (refused.status_code, "shipped" in refused.json()["detail"]) == (409, True)
