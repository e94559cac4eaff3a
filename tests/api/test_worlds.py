"""Headless worlds over HTTP: another program demonstrates, plays and tries."""

from __future__ import annotations

import asyncio
import io
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
import pytest

from evastudio.api import worlds as routes
from evastudio.api.arrays import NPZ, npz
from evastudio.api.context import Context
from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.live.jobs import Jobs
from evastudio.live.stages import Stages
from evastudio.studio.filming import film
from evastudio.workspace import Workspace
from evastudio.world.rollout import roll_out

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


def opened(studio: Studio, **body: Any) -> tuple[dict[str, Any], str]:
    """New worlds, and their path."""
    answer = studio.client.post(f"{API}/worlds", json={"scene": "asteroids", **body})
    assert answer.status_code == 201, answer.text
    made = answer.json()
    return made, f"{API}/worlds/{made['id']}"


def test_a_program_demonstrates_and_its_take_is_in_the_session(studio: Studio) -> None:
    session = studio.client.post(
        f"{API}/sessions", json={"scene": "asteroids", "name": "By worlds", "demonstrator": "me"}
    ).json()
    made, path = opened(studio, seeds=[4], session=session["id"], pilot="my planner")
    assert made["demonstrating"] == {
        "session": session["id"],
        "pilot": "program:my planner",
        "pairs": 0,
        "problem": None,
    }
    seen = studio.client.get(f"{path}/state").json()
    while seen["steps"][0] < 40 and not seen["ended"]:
        actions = [[0.01 * seen["states"][0][4], 0.0]]
        seen = studio.client.post(f"{path}/step", json={"actions": actions}).json()
    assert studio.client.get(path).json()["demonstrating"]["pairs"] == seen["steps"][0]
    assert studio.client.delete(path).status_code == 204
    (take,) = studio.client.get(f"{API}/sessions/{session['id']}/takes").json()["items"]
    assert (take["pilot"], take["pairs"], take["seed"]) == (
        "program:my planner",
        seen["steps"][0],
        4,
    )
    assert studio.client.get(path).status_code == 404


def test_a_policy_plays_as_it_does_in_a_rollout(studio: Studio) -> None:
    scene = headless.make_scene(studio.workspace, "asteroids", {"density": 0.5})
    pilot = headless.find_pilot("scripted:keys")
    flown = roll_out(scene, pilot, [1, 2, 3])
    _, path = opened(studio, seeds=[1, 2, 3], options={"density": 0.5})
    seen: dict[str, Any] = {"ended": False}
    while not seen["ended"]:
        body = {"pilot": "scripted:keys", "steps": 100}
        seen = studio.client.post(f"{path}/play", json=body).json()
    assert seen["steps"] == flown.steps.tolist()
    assert seen["outcomes"] == [scene.outcomes[code] for code in flown.outcomes]
    studio.client.delete(path)


def test_a_crowd_is_stepped_by_its_lead_or_whole(studio: Studio) -> None:
    made, path = opened(studio, scene="crowd", seeds=[1])
    assert made["characters"] == 60
    size = len(made["action"])
    lead = np.zeros((1, size)).tolist()
    everybody = np.zeros((3, 1, 60, size)).tolist()
    assert studio.client.post(f"{path}/step", json={"actions": lead}).json()["steps"] == [1]
    seen = studio.client.post(f"{path}/step", json={"actions": everybody}).json()
    assert seen["steps"] == [4]
    assert np.shape(seen["states"]) == (1, 60, len(made["state"]))
    seen = studio.client.post(f"{path}/reset", json={"seeds": [2, 3]}).json()
    assert np.shape(seen["states"]) == (2, 60, len(made["state"]))
    assert path.rpartition("/")[2] in [
        one["id"] for one in studio.client.get(f"{API}/worlds").json()["items"]
    ]
    studio.client.delete(path)


def arrays_of(answer: httpx.Response) -> dict[str, Any]:
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == NPZ
    return dict(np.load(io.BytesIO(answer.content)))


def test_arrays_travel_as_npz_too(studio: Studio) -> None:
    made, path = opened(studio, seeds=[1, 2], perception="paper")
    actions = np.random.default_rng(0).uniform(-0.1, 0.1, (4, 2, len(made["own_action"])))
    headers = {"Content-Type": NPZ}
    answer = studio.client.post(
        f"{path}/step?format=npz&frame=own", content=npz({"actions": actions}), headers=headers
    )
    seen = arrays_of(answer)
    told = studio.client.get(f"{path}/state").json()
    assert told["steps"] == [4, 4]
    assert np.array_equal(seen["states"], told["states"])
    assert [made["outcomes"][code] for code in seen["outcomes"]] == told["outcomes"]
    for arrays in ({}, {"actions": actions, "more": actions}):
        wrong = studio.client.post(f"{path}/step", content=npz(arrays), headers=headers)
        assert (wrong.status_code, "expected actions alone" in wrong.text) == (422, True)
    studio.client.delete(path)


def test_worlds_are_saved_and_go_on_in_others(studio: Studio) -> None:
    _, path = opened(studio, scene="crowd", seeds=[5])
    studio.client.post(f"{path}/play", json={"pilot": "crowd-and-boulder", "steps": 9})
    kept = studio.client.get(f"{path}/snapshot?fixed=true")
    arrays = arrays_of(kept)
    assert arrays["seeds"].tolist() == [5]
    body = {"pilot": "crowd-and-boulder", "steps": 20}
    expected = studio.client.post(f"{path}/play", json=body).json()
    _, other = opened(studio, scene="crowd", seeds=[1, 2])
    headers = {"Content-Type": NPZ}
    told = studio.client.put(f"{other}/snapshot", content=kept.content, headers=headers)
    assert told.json()["steps"] == [9]
    assert studio.client.post(f"{other}/play", json=body).json() == expected
    for bad, status, says in (
        (b"PK", 422, "not arrays"),
        (npz({**arrays, "seeds": np.array([6])}), 422, "not those of its seeds"),
        (npz({**arrays, "moving.lead": np.array([60])}), 422, "led by"),
        (kept.content[:5000], 422, "not arrays"),
    ):
        answer = studio.client.put(f"{other}/snapshot", content=bad, headers=headers)
        assert answer.status_code == status
        assert says in answer.json()["detail"]
    assert studio.client.put(f"{other}/snapshot", json={}).status_code == 415
    for one in (path, other):
        studio.client.delete(one)


@pytest.mark.parametrize(
    ("change", "body", "status", "says"),
    [
        ("", {"seeds": [1], "scene": "nowhere"}, 404, "no scene"),
        ("", {"seeds": []}, 422, "seeds"),
        ("", {"seeds": [-1]}, 422, "seeds"),
        ("", {"seeds": [1], "session": 999}, 404, "no session"),
        ("", {"seeds": [1], "perception": "sixth"}, 404, "perception"),
        ("/step", {"actions": [0.0, 0.0]}, 422, "actions"),
        ("/step", {"actions": [[0.0]]}, 422, "expected (1, 2)"),
        ("/step", {"actions": [[0.0, 0.0], [0.0]]}, 422, "not a table"),
        ("/step?frame=mine", {"actions": [[0.0, 0.0]]}, 422, "frame"),
        ("/play", {"pilot": "ghost"}, 404, "ghost"),
        ("/play", {"pilot": "crowd-fleeing"}, 409, "made for scene"),
        ("/play", {"pilot": "straight", "steps": 10**9}, 422, "steps"),
        ("/reset", {"seeds": [2**60]}, 422, "seeds"),
    ],
)
def test_what_cannot_be_is_a_problem_with_a_sentence(
    studio: Studio, change: str, body: dict[str, Any], status: int, says: str
) -> None:
    path = f"{API}/worlds"
    if change:
        path = opened(studio, seeds=[1])[1]
    else:
        body = {"scene": "asteroids", **body}
    answer = studio.client.post(path + change, json=body)
    assert (answer.status_code, answer.headers["content-type"]) == (
        status,
        "application/problem+json",
    )
    assert says in answer.json()["detail"]
    if change:
        studio.client.delete(path)


def test_worlds_nobody_asks_for_close_themselves_and_keep_the_take(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "IDLE_S", 0.02)
    scene = headless.make_scene(workspace, "asteroids")

    async def left_alone(store: Store, session: int) -> Context:
        context = Context(workspace, store, Jobs(), Stages(workspace, store), film)
        batch = context.worlds.open("asteroids", [1], session=session)
        batch.step(np.zeros((7, 1, 2)))
        await routes._close_when_idle(batch, context)
        return context

    with Store(workspace.store_url) as store:
        session = store.create_session(scene, "Left", "x", 0.0)
        context = asyncio.run(left_alone(store, session))
        assert context.worlds.all() == []
        assert [take.pairs for take in store.takes(session)] == [7]
        context.jobs.close()
