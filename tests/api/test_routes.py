"""The API against a studio that runs: record, clean, fit and play without a page."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from safetensors.numpy import save
from websockets.asyncio.client import ClientConnection, connect

from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.workspace import shipped

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
WAIT_S = 60.0


async def until(
    socket: ClientConnection, wanted: Callable[[dict[str, Any]], bool]
) -> dict[str, Any]:
    """The next message that is as wanted."""
    async with asyncio.timeout(WAIT_S):
        while True:
            message: dict[str, Any] = json.loads(await socket.recv())
            if wanted(message):
                return message


def drive(studio: Studio, stage: dict[str, Any]) -> connect:
    url = studio.base.replace("http", "ws") + stage["socket"]
    headers = {"Authorization": f"Bearer {studio.token}"}
    return connect(url, additional_headers=headers, proxy=None)


def in_phase(phase: str) -> Callable[[dict[str, Any]], bool]:
    return lambda message: message["type"] == "status" and message["phase"] == phase


def ended(job: int) -> Callable[[dict[str, Any]], bool]:
    return lambda message: (
        message["type"] == "job"
        and message["id"] == job
        and message["state"] in {"done", "failed", "cancelled"}
    )


def test_a_program_flies_cleans_fits_and_plays(studio: Studio) -> None:
    """The whole way over HTTP and the stage's websocket, on the studio's real clock."""
    session = studio.client.post(
        f"{API}/sessions", json={"scene": "asteroids", "name": "By program"}
    ).json()
    body = {"scene": "asteroids", "session": session["id"], "options": {"density": 0.5}, "seed": 6}
    stage = studio.client.post(f"{API}/stages", json=body).json()

    async def fly() -> None:
        async with drive(studio, stage) as socket:

            async def say(**message: Any) -> None:
                await socket.send(json.dumps(message))

            await say(type="command", name="demonstrate")
            await until(socket, in_phase("recording"))
            await say(type="keys", held=["KeyA"], time_ms=0.0, seq=1)
            await until(socket, lambda told: told == {"type": "ack", "seq": 1})
            await until(socket, lambda told: told.get("pairs", 0) >= 60)
            await say(type="command", name="pause")
            await until(socket, in_phase("paused"))
            await say(type="command", name="resume")
            await until(socket, in_phase("recording"))
            await say(type="command", name="stop")
            told = await until(socket, lambda m: in_phase("ready")(m) and m["takes_kept"] == 1)
            assert told["pairs_kept"] >= 60
            job = studio.client.post(f"{API}/sessions/{session['id']}/clean", json={}).json()
            cleaned = await until(socket, ended(job["id"]))
            assert cleaned["state"] == "done", cleaned
            body = {"learner": "knn", "name": "by-program", "settings": {"k": 3}}
            job = studio.client.post(f"{API}/sessions/{session['id']}/fit", json=body).json()
            fitted = await until(socket, ended(job["id"]))
            assert fitted["state"] == "done", fitted
            await say(type="command", name="play", policy="by-program")
            playing = await until(socket, in_phase("playing"))
            assert playing["policy"] == "by-program"
            await until(socket, lambda told: told.get("seconds", 0.0) > 1.0)
            await say(type="command", name="stop")
            await until(socket, in_phase("ready"))

    asyncio.run(fly())
    takes = studio.client.get(f"{API}/sessions/{session['id']}/takes").json()["items"]
    assert len(takes) == 1
    with Store(studio.workspace.store_url) as store:
        data = store.load_take(takes[0]["id"])
        assert len(data.actions) == takes[0]["pairs"]
        assert data.actions[:, 0].max() == pytest.approx(0.10472, abs=1e-4)
        assert data.actions[:, 1].max() == 0.0
    policy = studio.client.get(f"{API}/policies/by-program").json()
    assert (policy["session"], policy["stale"], policy["problem"]) == ("By program", False, None)

    trashed = studio.client.post(f"{API}/takes/{takes[0]['id']}/trash").json()
    assert trashed["trashed"]
    assert studio.client.get(f"{API}/policies/by-program").json()["stale"]
    studio.client.post(f"{API}/takes/{takes[0]['id']}/restore")
    assert not studio.client.get(f"{API}/policies/by-program").json()["stale"]
    undone = studio.client.delete(f"{API}/sessions/{session['id']}/clean").json()
    assert undone["cleaning"] is None
    assert studio.client.delete(f"{API}/stages/{stage['id']}").status_code == 204
    assert studio.client.get(f"{API}/stages/{stage['id']}").status_code == 404


def test_a_program_compares_pilots_on_the_same_worlds(studio: Studio) -> None:
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    names = ["asteroids-careful", "straight"]
    body = {"scene": "asteroids", "policies": names, "worlds": 5, "options": {"density": 0.5}}

    async def compare() -> dict[str, Any]:
        async with drive(studio, stage) as socket:
            job = studio.client.post(f"{API}/evaluations", json=body).json()
            told = await until(socket, ended(job["id"]))
            assert told["state"] == "done", told
            return told["result"]

    told = asyncio.run(compare())
    kept = studio.client.get(f"{API}/evaluations/{told['evaluation']}").json()
    assert list(kept["result"]["pilots"]) == names
    assert kept["result"]["pilots"] == told["policies"]
    (difference,) = kept["result"]["differences"]
    assert difference["pilots"] == names
    listed = studio.client.get(f"{API}/evaluations", params={"scene": "asteroids"}).json()
    assert kept in listed["items"]
    assert studio.client.get(f"{API}/evaluations", params={"scene": "crowd"}).json()["items"] == []


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "says"),
    [
        ("GET", "/evaluations/999", None, 404, "no evaluation"),
        ("POST", "/evaluations", {"scene": "asteroids", "policies": []}, 422, "policies"),
        ("POST", "/evaluations", {"scene": "asteroids", "policies": ["ghost"]}, 404, "ghost"),
        ("POST", "/evaluations", {"scene": "nowhere", "policies": ["straight"]}, 404, "no scene"),
        (
            "POST",
            "/evaluations",
            {"scene": "crowd", "policies": ["asteroids-careful"]},
            409,
            "made for scene",
        ),
        ("GET", "/scenes/nowhere", None, 404, "no scene 'nowhere'"),
        ("GET", "/sessions/999", None, 404, "no session '999'"),
        ("GET", "/sessions/999/takes", None, 404, "no session '999'"),
        ("GET", f"/sessions/{10**20}", None, 404, f"no session '{10**20}'"),
        ("POST", f"/takes/{10**20}/trash", None, 404, "no take"),
        ("POST", f"/takes/-{10**20}/restore", None, 404, "no take"),
        ("POST", "/sessions", {"scene": "nowhere", "name": "x"}, 404, "no scene"),
        ("POST", "/sessions", {"scene": "asteroids", "name": " "}, 422, "printable"),
        ("POST", "/sessions", {"scene": "asteroids"}, 422, "name"),
        ("POST", "/sessions", {"scene": "asteroids", "name": "x", "more": 1}, 422, "more"),
        ("POST", "/sessions/999/clean", {}, 404, "no session"),
        ("POST", "/sessions/999/fit", {}, 404, "no session"),
        ("POST", "/sessions/999/tune", {}, 404, "no session"),
        ("POST", "/sessions/999/diagnose", {}, 404, "no session"),
        ("POST", "/takes/999/trash", None, 404, "no take"),
        ("GET", "/jobs/999", None, 404, "no job"),
        ("GET", "/policies/ghost", None, 404, "no policy"),
        ("POST", "/stages", {"scene": "asteroids", "options": {"density": 1e9}}, 422, "density"),
        ("POST", "/stages", {"scene": "asteroids", "options": {"fog": 1}}, 404, "fog"),
        ("POST", "/stages", {"scene": "asteroids", "options": {"self": 1}}, 404, "self"),
        ("POST", "/stages", {"scene": "asteroids", "session": 999}, 404, "no session"),
        ("POST", "/stages", {"scene": "asteroids", "session": -(10**20)}, 404, "no session"),
        ("POST", "/stages", {"scene": "asteroids", "seed": -1}, 422, "seed"),
        ("GET", "/stages/ghost", None, 404, "no stage"),
    ],
)
def test_bad_input_is_a_problem_with_a_sentence(
    studio: Studio, method: str, path: str, body: Any, status: int, says: str
) -> None:
    answer = studio.client.request(method, API + path, json=body)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert says in answer.json()["detail"]


def test_work_on_an_empty_session_says_what_it_needs_first(studio: Studio) -> None:
    made = studio.client.post(
        f"{API}/sessions", json={"scene": "asteroids", "name": "Empty"}
    ).json()
    for work in ("clean", "fit"):
        answer = studio.client.post(f"{API}/sessions/{made['id']}/{work}", json={})
        assert answer.status_code == 422
        assert "Record a take first" in answer.json()["detail"]


def test_a_stage_says_what_it_does_not_understand_and_goes_on(studio: Studio) -> None:
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()

    async def babble() -> None:
        async with drive(studio, stage) as socket:
            for text in ("{", "[]", '{"type":"keys"}', '{"type":"dance"}', "x" * 10_000):
                await socket.send(text)
                await until(socket, lambda told: told["type"] == "notice")
            for policy, says in (("ghost", "no policy 'ghost'"), (None, "No policy was named")):
                command = {"type": "command", "name": "play", "policy": policy}
                await socket.send(json.dumps(command))
                told = await until(socket, lambda told: told["type"] == "notice")
                assert says in told["text"]
            await socket.send(json.dumps({"type": "command", "name": "play", "policy": "straight"}))
            await until(socket, in_phase("playing"))

    asyncio.run(babble())


def test_a_session_of_another_scene_version_takes_no_more_takes(studio: Studio) -> None:
    headless.record(studio.workspace, "asteroids", minutes=0.1, session="Before")
    own = studio.workspace.root / "scenes"
    own.mkdir(exist_ok=True)
    source = (shipped() / "scenes" / "asteroids.py").read_text()
    (own / "asteroids.py").write_text(source.replace("version = 1", "version = 2"))
    try:
        session = studio.client.get(f"{API}/sessions").json()["items"][0]
        body = {"scene": "asteroids", "session": session["id"]}
        answer = studio.client.post(f"{API}/stages", json=body)
        assert answer.status_code == 409
        assert "version 1 of the scene" in answer.json()["detail"]
    finally:
        (own / "asteroids.py").unlink()


def test_a_job_is_cancelled_over_http(studio: Studio) -> None:
    made = headless.record(studio.workspace, "asteroids", "scripted:keys", 3.0, session="Long")
    body = {"learner": "svr", "settings": {"C": 1e6, "epsilon": 1e-5, "gamma": 5.0}}
    job = studio.client.post(f"{API}/sessions/{made['session']}/fit", json=body).json()
    cancelled = studio.client.delete(f"{API}/jobs/{job['id']}").json()
    assert cancelled["state"] == "cancelled"
    assert studio.client.get(f"{API}/jobs/{job['id']}").json()["state"] == "cancelled"
    assert job["id"] in [one["id"] for one in studio.client.get(f"{API}/jobs").json()["items"]]


def test_two_pages_at_one_stage_share_the_keys(studio: Studio) -> None:
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids", "seed": 6}).json()

    async def share() -> None:
        async with drive(studio, stage) as first:
            async with drive(studio, stage) as second:
                await first.send(json.dumps({"type": "command", "name": "demonstrate"}))
                await until(first, in_phase("recording"))
                for page, key in ((first, "KeyA"), (second, "KeyW")):
                    held = {"type": "keys", "held": [key], "time_ms": 0.0, "seq": 1}
                    await page.send(json.dumps(held))
                    await until(page, lambda told: told["type"] == "ack")
                told = await until(first, lambda told: told.get("pairs", 0) >= 15)
            # The second page is gone and so is its key; the first still steers.
            await until(first, lambda now: now.get("pairs", 0) >= told["pairs"] + 15)
            await first.send(json.dumps({"type": "command", "name": "restart"}))
            await until(first, in_phase("countdown"))

    asyncio.run(share())
    session = studio.client.get(f"{API}/sessions").json()["items"][0]
    takes = studio.client.get(f"{API}/sessions/{session['id']}/takes").json()["items"]
    with Store(studio.workspace.store_url) as store:
        actions = store.load_take(takes[0]["id"]).actions
    assert actions[-1, 0] == pytest.approx(0.10472, abs=1e-4)
    assert actions[:, 1].max() > 0.05
    assert actions[-1, 1] == 0.0


def test_a_damaged_policy_is_listed_with_its_problem_and_does_not_play(studio: Studio) -> None:
    (studio.workspace.policies / "broken.safetensors").write_bytes(b"nothing of the kind")
    listed = studio.client.get(f"{API}/policies", params={"scene": "asteroids"}).json()["items"]
    problem = next(item["problem"] for item in listed if item["name"] == "broken")
    assert "broken.safetensors" in problem
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    answer = studio.client.post(
        f"{API}/stages/{stage['id']}/commands", json={"name": "play", "policy": "broken"}
    )
    assert answer.status_code == 409
    assert answer.json()["detail"].count("Traceback") == 0


def test_a_policy_that_describes_itself_oddly_is_listed_with_its_problem(studio: Studio) -> None:
    for number, odd in enumerate(
        ({"scene": [1]}, {"settings": "none"}, {"extra": 3}, {"pairs": "many"}, {"session": {}})
    ):
        described = json.dumps({"format": 1, "scene": {}, "extra": {}, **odd})
        content = save({"a": np.zeros(1)}, {"evastudio": described})
        (studio.workspace.policies / f"odd-{number}.safetensors").write_bytes(content)
    listed = studio.client.get(f"{API}/policies").json()["items"]
    odd_ones = [item for item in listed if item["name"].startswith("odd-")]
    assert len(odd_ones) == 5
    assert all(item["problem"] for item in odd_ones)


def test_a_scene_file_of_ones_own_that_is_not_ready_disturbs_nothing(studio: Studio) -> None:
    own = studio.workspace.root / "scenes"
    own.mkdir(exist_ok=True)
    file = own / "half.py"
    head = "from evastudio.world.scene import Scene\nclass Half(Scene):\n"
    try:
        for body in ("    pass\n", "    name = 'half'\n"):
            file.write_text(head + body)
            listed = studio.client.get(f"{API}/scenes").json()["items"]
            assert [scene["name"] for scene in listed] == ["asteroids", "crowd", "street"]
            assert [len(scene["symbols"]) for scene in listed] == [0, 4, 0]
            answer = studio.client.get(f"{API}/scenes/half")
            assert answer.status_code == 404
        file.write_text("import sys\nsys.exit(3)\n")
        assert studio.client.get(f"{API}/scenes").status_code == 200
    finally:
        file.unlink()


def test_a_policy_of_another_scene_version_is_refused(studio: Studio) -> None:
    headless.record(studio.workspace, "asteroids", minutes=0.1, session="Old")
    headless.fit(studio.workspace, "Old", learner="knn", name="old", settings={"k": 1})
    own = studio.workspace.root / "scenes"
    own.mkdir(exist_ok=True)
    source = (shipped() / "scenes" / "asteroids.py").read_text()
    (own / "asteroids.py").write_text(source.replace("version = 1", "version = 2"))
    try:
        policy = studio.client.get(f"{API}/policies/old").json()
        assert "version 1 of the scene" in policy["problem"]
        stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
        answer = studio.client.post(
            f"{API}/stages/{stage['id']}/commands", json={"name": "play", "policy": "old"}
        )
        assert answer.status_code == 409
        assert "version 1" in answer.json()["detail"]
    finally:
        (own / "asteroids.py").unlink()
