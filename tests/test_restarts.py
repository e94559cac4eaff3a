"""After a restart of the studio a browser goes on where it was, without a new address."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from websockets.asyncio.client import connect

from evastudio.demonstrations.store import Store
from evastudio.live.signed_in import FILE, RUNS, earlier_runs
from evastudio.workspace import Workspace
from tests.conftest import launch
from tests.test_faults import at_stage, recorded, until

if TYPE_CHECKING:
    from conftest import Studio

STAGE = {"scene": "asteroids", "options": {"density": 0.5}}


@pytest.fixture
def restarted(tmp_path: Path) -> Iterator[Callable[..., Studio]]:
    """Start a studio at the port that the one before had, which is gone by then."""
    started: list[Studio] = []

    def start(*arguments: str) -> Studio:
        port = started[-1].base.rpartition(":")[2] if started else "0"
        found = launch(Workspace(tmp_path / "studio"), arguments=("--port", port, *arguments))
        started.append(found)
        return found

    yield start
    for studio in started:
        studio.client.close()
        if studio.process.poll() is None:
            studio.stop()
        elif studio.process.stdout is not None:
            studio.process.stdout.close()


def entered(studio: Studio) -> str:
    """The cookie of a browser that opens the printed address."""
    answer = httpx.get(studio.url, trust_env=False)
    return str(answer.headers["set-cookie"]).partition(";")[0]


def asked(studio: Studio, cookie: str) -> int:
    """What a browser with that cookie is answered."""
    path = f"{studio.base}/api/v1/me"
    return httpx.get(path, headers={"Cookie": cookie}, trust_env=False).status_code


def test_a_page_goes_on_in_its_session_after_a_restart(
    restarted: Callable[..., Studio],
) -> None:
    studio = restarted()
    cookie = entered(studio)
    stage = studio.client.post("/api/v1/stages", json=STAGE).json()

    async def demonstrate(studio: Studio, stage: dict[str, Any]) -> dict[str, Any]:
        async with at_stage(studio, stage) as socket:
            told = await until(socket, recorded(20))
            studio.kill()
            return told

    told = asyncio.run(demonstrate(studio, stage))
    again = restarted()
    assert again.url != studio.url
    assert asked(again, cookie) == 200

    # What the page does by itself: its stage is gone, and it opens another in the same session.
    shown = {"Cookie": cookie, "Origin": again.base}
    with httpx.Client(base_url=again.base, headers=shown, trust_env=False) as browser:
        assert browser.get(f"/api/v1/stages/{stage['id']}").status_code == 404
        body = {**STAGE, "session": told["session"]["id"]}
        other = browser.post("/api/v1/stages", json=body).json()

    async def joined() -> dict[str, Any]:
        url = again.base.replace("http", "ws") + other["socket"]
        async with connect(url, additional_headers=shown, proxy=None) as socket:
            return await until(socket, lambda told: told["session"] is not None)

    status = asyncio.run(joined())
    assert status["session"] == told["session"]
    assert status["takes_kept"] == 1
    assert status["phase"] == "ready"
    asyncio.run(demonstrate(again, other))
    with Store(again.workspace.store_url) as store:
        (session,) = store.sessions()
        first, second = store.takes(session.id)
    assert first.pairs >= 20 - 0.5 / (1 / 15)
    assert first.outcome is None
    assert second.pairs > 0


def test_a_token_that_somebody_chose_lets_nobody_of_an_earlier_run_in(
    restarted: Callable[..., Studio],
) -> None:
    studio = restarted()
    cookie = entered(studio)
    studio.stop()
    chosen = restarted("--token", "a-token-that-was-chosen")
    assert asked(chosen, cookie) == 401
    cookie = entered(chosen)
    chosen.stop()
    assert asked(restarted("--token", "another-that-was-chosen"), cookie) == 401


def test_the_latest_runs_are_remembered(tmp_path: Path) -> None:
    for run in range(RUNS + 3):
        earlier = earlier_runs(tmp_path, str(run))
    assert earlier == {str(run) for run in range(3, RUNS + 2)}
    path = tmp_path / FILE
    assert path.stat().st_mode & 0o077 == 0
    for damaged in ("", "{", '{"a": 1}', "3", "[1, null]"):
        path.write_text(damaged)
        assert earlier_runs(tmp_path, "now") in (frozenset(), {"a"})
        assert json.loads(path.read_text())[0] == "now"
