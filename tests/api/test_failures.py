"""Over HTTP: where a policy fails and nobody has been, how one gets there, and why it did that."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from evastudio.live import headless
from tests.api.jobs import result_of

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
FIELD = {"density": 0.3}


def test_one_is_taken_to_where_it_fails_and_asks_why(studio: Studio) -> None:
    workspace = studio.workspace
    headless.record(workspace, "asteroids", minutes=0.5, options=FIELD, session="Few")
    headless.fit(workspace, "Few", learner="knn", delay="off", name="few")
    body = {"policy": "straight", "scene": "asteroids", "options": FIELD, "worlds": 8, "most": 1}
    told = result_of(studio, studio.client.post(f"{API}/failures", json=body))
    (failure,) = told["failures"]
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()["id"]

    def ask(**command: Any) -> Any:
        return studio.client.post(f"{API}/stages/{stage}/commands", json=command)

    there = {"seed": failure["seed"], "seconds": failure["seconds"] - 3.0}
    status = ask(name="play", policy="straight", options=FIELD, **there).json()
    assert (status["phase"], status["mode"], status["seed"]) == ("paused", "play", failure["seed"])
    assert abs(status["seconds"] - there["seconds"]) < 0.01
    assert "program" in status["silent"]
    assert studio.client.get(f"{API}/stages/{stage}/why").json() is None

    status = ask(name="play", policy="few", options=FIELD, seed=3, seconds=2.0).json()
    assert (status["phase"], status["silent"]) == ("paused", None)
    why = studio.client.get(f"{API}/stages/{stage}/why").json()
    first = why["moments"][0]
    assert (why["policy"], why["silent"], first["session"]) == ("few", None, "Few")
    assert first["number"] >= 1
    ask(name="forget", take=first["take"], step=first["step"])
    again = studio.client.get(f"{API}/stages/{stage}/why").json()["moments"]
    assert (first["take"], first["step"]) not in {(one["take"], one["step"]) for one in again}

    assert ask(name="take-over").json()["mode"] == "correct"
    assert ask(name="hand-back").json()["mode"] == "play"
    studio.client.delete(f"{API}/stages/{stage}")


def test_one_is_taken_to_where_nobody_has_been(studio: Studio) -> None:
    made = headless.record(
        studio.workspace, "asteroids", minutes=0.3, options=FIELD, session="Thin"
    )
    url = f"{API}/sessions/{made['session']}/places"
    place = result_of(studio, studio.client.post(url, json={"places": 1}))["places"][0]
    body = {"scene": "asteroids", "session": made["session"]}
    stage = studio.client.post(f"{API}/stages", json=body).json()["id"]
    push = {"keys": place["keys"], "steps": place["steps"]}
    command = {"name": "visit", "take": place["take"], "step": place["step"], "push": push}
    address = f"{API}/stages/{stage}/commands"
    assert studio.client.post(address, json=command).json()["phase"] == "countdown"
    late = {**command, "step": 10**6}
    assert studio.client.post(address, json=late).status_code == 422
    assert studio.client.post(address, json={"name": "visit"}).status_code == 422
    told = studio.client.post(address, json={"name": "demonstrate", "pushes": True}).json()
    assert (told["pushes"], told["pushed"]) == (True, False)
    studio.client.delete(f"{API}/stages/{stage}")
    empty = studio.client.post(f"{API}/sessions", json={"scene": "asteroids", "name": "Empty"})
    url = f"{API}/sessions/{empty.json()['id']}/places"
    assert studio.client.post(url, json={}).status_code == 422
