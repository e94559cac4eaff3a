"""Health, metrics and logs say how a studio is, and nothing about whom or what it holds."""

from __future__ import annotations

import asyncio
import json
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from starlette.types import Receive, Scope, Send
from websockets.asyncio.client import connect

from evastudio.observing.health import Health

if TYPE_CHECKING:
    from conftest import Studio

SECRET = "Zebrafink Wunderlich"


def metrics(studio: Studio) -> dict[str, float]:
    """Every sample by its name and labels."""
    answer = studio.client.get("/metrics")
    assert answer.headers["content-type"].startswith("text/plain; version=0.0.4")
    lines = [line for line in answer.text.splitlines() if line and not line.startswith("#")]
    return {name: float(value) for name, _, value in (line.rpartition(" ") for line in lines)}


def test_health_needs_no_token_and_tells_nothing(studio: Studio) -> None:
    for headers in ({}, {"Host": "somewhere.else"}, {"Authorization": "Bearer wrong"}):
        answer = httpx.get(f"{studio.base}/health", headers=headers, trust_env=False)
        assert (answer.status_code, answer.json()) == (200, {"status": "ok"})
    assert httpx.post(f"{studio.base}/health", trust_env=False).status_code == 405
    assert httpx.get(f"{studio.base}/metrics", trust_env=False).status_code == 401


def test_a_store_that_hangs_or_refuses_is_not_healthy_and_is_asked_by_one_thread() -> None:
    async def nothing(scope: Scope, receive: Receive, send: Send) -> None:
        raise AssertionError

    async def look(ask: Callable[[], None], times: int) -> list[int]:
        health = Health(nothing, ask)
        transport = httpx.ASGITransport(health)
        async with httpx.AsyncClient(transport=transport, base_url="http://studio") as client:
            answers = await asyncio.gather(*(client.get("/health") for _ in range(times)))
        return [answer.status_code for answer in answers]

    def refuse() -> None:
        raise OSError("gone")

    assert asyncio.run(look(refuse, 1)) == [503]
    hanging, asked = threading.Event(), []

    def hang() -> None:
        asked.append(1)
        hanging.wait(60.0)

    async def look_and_let_go() -> list[int]:
        try:
            return await look(hang, 5)
        finally:
            hanging.set()

    assert asyncio.run(look_and_let_go()) == [503] * 5
    assert len(asked) == 1


def test_metrics_count_steps_requests_sockets_and_the_store(studio: Studio) -> None:
    before = metrics(studio)
    session = {"scene": "asteroids", "name": SECRET, "demonstrator": SECRET}
    assert studio.client.post("/api/v1/sessions", json=session).status_code == 201
    assert studio.client.get("/api/v1/sessions/999999").status_code == 404
    assert studio.client.get(f"/api/v1/{SECRET}").status_code == 404
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids", "seed": 1}).json()
    headers = {"Authorization": f"Bearer {studio.token}"}

    async def play() -> dict[str, float]:
        url = studio.base.replace("http", "ws") + stage["socket"]
        async with connect(url, additional_headers=headers, proxy=None) as socket:
            play = {"type": "command", "name": "play", "policy": "straight"}
            await socket.send(json.dumps(play))
            while json.loads(await socket.recv()).get("steps", 0) < 5:
                pass
            return await asyncio.to_thread(metrics, studio)

    during = asyncio.run(play())
    assert during["evastudio_steps_total"] >= before["evastudio_steps_total"] + 5
    assert during["evastudio_step_lateness_seconds_count"] == during["evastudio_steps_total"]
    assert during['evastudio_stages{phase="playing"}'] >= 1
    assert during['evastudio_sockets{route="/api/v1/stages/{stage}/socket"}'] >= 1
    assert during['evastudio_queue_length{queue="recorder"}'] == 0
    assert during["process_resident_memory_bytes"] > 1e7
    assert during['evastudio_store_seconds_count{operation="insert"}'] >= 1
    assert during['evastudio_store_seconds_count{operation="transaction"}'] >= 1
    for method, route, status in (
        ("POST", "/api/v1/sessions", 201),
        ("GET", "/api/v1/sessions/{session}", 404),
        ("GET", "none", 404),
        ("GET", "/metrics", 200),
    ):
        name = "evastudio_requests_total"
        assert during[f'{name}{{method="{method}",route="{route}",status="{status}"}}'] >= 1
    studio.client.delete(f"/api/v1/stages/{stage['id']}")
    after = metrics(studio)
    assert after["evastudio_steps_total"] >= during["evastudio_steps_total"]


def test_metrics_hold_no_name_no_token_and_few_series_whatever_is_asked(studio: Studio) -> None:
    for number in range(30):
        studio.client.get(f"/{SECRET}/{number}", params={"token": studio.token})
        studio.client.request(f"METHOD{number}", "/api/v1/sessions")
        studio.client.get(f"/web/{number}.js")
        studio.client.get(f"/api/v1/takes/{number}")
    text = studio.client.get("/metrics").text
    assert "Zebrafink" not in text
    assert studio.token not in text
    assert "METHOD" not in text
    assert not re.search(r'route="[^"]*\d{2}', text)
    assert len(text.splitlines()) < 2000


@pytest.mark.parametrize("given", ["", "short", "x" * 65, "with space and more", "né-né-né-né"])
def test_an_id_that_is_not_sane_is_replaced(studio: Studio, given: str) -> None:
    answer = studio.client.get("/api/v1/scenes", headers={"X-Request-ID": given.encode()})
    assert answer.headers["x-request-id"] != given
    assert re.fullmatch("[0-9a-f]{16}", answer.headers["x-request-id"])


def test_the_id_of_a_request_is_told_in_its_answer_its_problem_and_its_job(studio: Studio) -> None:
    mine = {"X-Request-ID": "my-own-id_1.2"}
    problem = studio.client.get("/api/v1/sessions/999999", headers=mine)
    assert problem.headers["x-request-id"] == problem.json()["request"] == "my-own-id_1.2"
    refused = httpx.get(f"{studio.base}/api/v1/sessions", headers=mine, trust_env=False)
    assert refused.headers["x-request-id"] == refused.json()["request"] == "my-own-id_1.2"
    asked = {"scene": "asteroids", "policies": ["straight"], "worlds": 1}
    job = studio.client.post("/api/v1/evaluations", json=asked, headers=mine).json()
    assert studio.client.get(f"/api/v1/jobs/{job['id']}").json()["request"] == "my-own-id_1.2"


def test_logs_are_json_lines_with_routes_and_ids_and_no_names_or_tokens(tmp_path: Path) -> None:
    with (tmp_path / "log").open("w+") as log:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser"),
                *("--json", "--workspace", str(tmp_path / "work")),
                *("--log-format", "json", "--log-level", "info"),
            ],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        assert process.stdout is not None
        base, _, token = json.loads(process.stdout.readline())["url"].partition("/?token=")
        headers = {"Authorization": f"Bearer {token}", "X-Request-ID": "followed-everywhere"}
        with httpx.Client(base_url=base, headers=headers, trust_env=False, timeout=60.0) as client:
            client.get("/", params={"token": token})
            client.get("/health")
            session = {"scene": "asteroids", "name": SECRET, "demonstrator": SECRET}
            made = client.post("/api/v1/sessions", json=session).json()
            client.get(f"/api/v1/sessions/{made['id']}", params={"name": SECRET})
            client.get("/api/v1/policies/" + SECRET)
        process.terminate()
        assert process.wait(timeout=60) == 0
        process.stdout.close()
        log.seek(0)
        written = log.read()
    assert "Zebrafink" not in written
    assert token not in written
    events = [json.loads(line) for line in written.splitlines()]
    requests = [event for event in events if event["message"] == "request"]
    assert ("POST", "/api/v1/sessions", 201) in {
        (event["method"], event["route"], event["status"]) for event in requests
    }
    assert "/api/v1/sessions/{session}" in {event["route"] for event in requests}
    assert "/health" not in {event["route"] for event in requests}
    assert {event["request"] for event in requests} == {"followed-everywhere"}
    assert all(event["seconds"] >= 0.0 for event in requests)
