"""Jobs as server-sent events: every end is told, once, to however many listen."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import httpx
import pytest

from evastudio.api import job_feed
from evastudio.api.job_feed import JobFeed
from evastudio.errors import ConflictError
from evastudio.live import headless
from evastudio.live.jobs import Job, JobState

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


class Known:
    """Jobs that a test says there are."""

    def __init__(self) -> None:
        self.now: dict[int, Job] = {}

    def feed(self) -> JobFeed:
        return JobFeed(self.now.values)

    def become(self, feed: JobFeed, number: int, state: JobState, progress: float = 0.0) -> None:
        self.now[number] = Job(number, "fit", None, state, progress)
        feed.tell(self.now[number])


@pytest.fixture
def jobs() -> Known:
    return Known()


def read(event: str) -> tuple[str, str, dict[str, Any]]:
    """Id, kind and job of an event."""
    fields = dict(line.split(": ", 1) for line in event.strip().splitlines())
    return fields["id"], fields["event"], json.loads(fields["data"])


def test_a_slow_listener_misses_steps_and_no_end(jobs: Known) -> None:
    async def follow() -> list[tuple[str, int, str]]:
        feed = jobs.feed()
        jobs.become(feed, 1, JobState.RUNNING)
        told = feed.listen()
        first = read(await anext(told))
        for share in range(1000):
            jobs.become(feed, 1, JobState.RUNNING, share / 1000)
        jobs.become(feed, 2, JobState.RUNNING)
        jobs.become(feed, 1, JobState.DONE, 1.0)
        rest = [read(await anext(told)) for _ in range(2)]
        feed.close()
        assert [event async for event in told] == []
        return [(kind, job["id"], job["state"]) for _, kind, job in (first, *rest)]

    assert asyncio.run(follow()) == [
        ("change", 1, "running"),
        ("change", 2, "running"),
        ("end", 1, "done"),
    ]


def test_who_comes_back_is_told_what_changed_meanwhile(jobs: Known) -> None:
    async def come_back() -> None:
        feed = jobs.feed()
        jobs.become(feed, 1, JobState.RUNNING)
        jobs.become(feed, 2, JobState.QUEUED)
        told = feed.listen()
        seen = [read(await anext(told)) for _ in range(2)]
        jobs.become(feed, 2, JobState.CANCELLED)
        (again,) = [read(await anext(feed.listen(seen[-1][0]))) for _ in range(1)]
        assert (again[1], again[2]["id"]) == ("end", 2)
        for unknown in ("other-5", "nonsense", "-", None):
            assert read(await anext(feed.listen(unknown)))[2]["id"] == 1
        assert feed.is_over(jobs.now[2], again[0])
        assert not feed.is_over(jobs.now[2], seen[-1][0])
        assert not feed.is_over(jobs.now[1], again[0])

    asyncio.run(come_back())


def test_one_job_is_followed_until_it_ends(jobs: Known) -> None:
    async def follow() -> list[str]:
        feed = jobs.feed()
        jobs.become(feed, 1, JobState.QUEUED)
        jobs.become(feed, 2, JobState.RUNNING)
        told = feed.listen(only=2)
        first = await anext(told)
        jobs.become(feed, 1, JobState.RUNNING)
        jobs.become(feed, 2, JobState.FAILED)
        return [read(event)[2]["state"] for event in (first, *[event async for event in told])]

    assert asyncio.run(follow()) == ["running", "failed"]


def test_a_silent_feed_says_that_it_is_there(jobs: Known, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_feed, "HEARTBEAT_S", 0.0)

    async def wait() -> str:
        return await anext(jobs.feed().listen())

    assert asyncio.run(wait()).startswith(":")


def test_only_so_many_listen(jobs: Known, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_feed, "MOST_LISTENERS", 1)

    async def crowd() -> None:
        feed = jobs.feed()
        jobs.become(feed, 1, JobState.RUNNING)
        first = feed.listen()
        await anext(first)
        with pytest.raises(ConflictError, match="already"):
            feed.listen()
        await first.aclose()  # type: ignore[attr-defined]
        feed.listen()

    asyncio.run(crowd())


def test_what_is_forgotten_is_forgotten(jobs: Known) -> None:
    async def forget() -> int:
        feed = jobs.feed()
        for number in range(50):
            jobs.become(feed, number, JobState.DONE)
            jobs.now.pop(number - 3, None)
        return len(feed._changes)

    assert asyncio.run(forget()) <= 4


def events(answer: httpx.Response) -> list[tuple[str, str, dict[str, Any]]]:
    """All of a stream that ends."""
    text = "".join(answer.iter_text())
    return [read(event) for event in text.split("\n\n") if event and event[0] != ":"]


def test_a_job_is_followed_over_http_and_run_again(studio: Studio) -> None:
    made = headless.record(studio.workspace, "asteroids", minutes=0.2, session="Followed")
    client = studio.client
    job = client.post(f"{API}/sessions/{made['session']}/clean", json={}).json()
    with client.stream("GET", f"{API}/jobs/{job['id']}/events") as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        told = events(answer)
    last, kind, ended = told[-1]
    assert (kind, ended["state"]) == ("end", "done")
    assert ended == client.get(f"{API}/jobs/{job['id']}").json()
    shares = [change["progress"] for _, _, change in told]
    assert shares == sorted(shares)
    path = f"{API}/jobs/{job['id']}/events"
    assert client.get(path, headers={"Last-Event-ID": last}).status_code == 204
    assert [event[2] for event in events(client.get(path))] == [ended]
    assert client.get(f"{API}/jobs/{10**6}/events").status_code == 404

    again = client.post(f"{API}/jobs/{job['id']}/again")
    assert again.status_code == 202
    number = again.json()["id"]
    with client.stream("GET", f"{API}/jobs/events", headers={"Last-Event-ID": last}) as answer:
        text = ""
        for part in answer.iter_text():
            text += part
            if f'"id": {number}' in text and "event: end" in text:
                break
    assert f'"id": {job["id"]},' not in text
    result = client.get(f"{API}/jobs/{number}").json()["result"]
    assert result["removed"] == ended["result"]["removed"]


def test_streams_end_with_the_studio(start_studio: Callable[..., Studio]) -> None:
    own = start_studio()
    with own.client.stream("GET", f"{API}/jobs/events") as answer:
        own.process.terminate()
        assert answer.read() == b""
    assert own.process.wait() == 0
