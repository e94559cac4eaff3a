"""What is made with nobody at the keys over HTTP, and lists page by page."""

from __future__ import annotations

import io
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from evastudio.live import headless

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
WAIT_S = 60.0


def result(studio: Studio, path: str, body: dict[str, Any]) -> dict[str, Any]:
    """What the job gives that a route starts."""
    started = studio.client.post(API + path, json=body)
    assert started.status_code == 202, started.text
    pause = threading.Event()
    until = time.monotonic() + WAIT_S
    while time.monotonic() < until:
        pause.wait(0.1)
        job = studio.client.get(f"{API}/jobs/{started.json()['id']}").json()
        if job["state"] in {"done", "failed", "cancelled"}:
            assert job["state"] == "done", job
            told: dict[str, Any] = job["result"]
            return told
    raise AssertionError(job)


def test_a_scripted_demonstrator_records_over_http_and_cleaning_is_looked_at_first(
    studio: Studio,
) -> None:
    body = {"scene": "asteroids", "pilot": "scripted:human", "minutes": 0.5, "session": "Shown"}
    made = result(studio, "/demonstrations", body)
    assert made["name"] == "Shown"
    seen = result(studio, f"/sessions/{made['session']}/clean/preview", {"worst": 3})
    session = studio.client.get(f"{API}/sessions/{made['session']}").json()
    assert session["cleaning"] is None
    assert seen["removed"] > 0
    assert len(seen["worst"]) == min(3, seen["removed"])
    first = seen["worst"][0]
    assert first["deviation"] > first["limit"]
    assert len(first["neighbors"]) == seen["neighbors"]
    cleaned = result(studio, f"/sessions/{made['session']}/clean", {})
    assert cleaned["removed"] == seen["removed"]
    assert cleaned["takes"] == seen["takes"]


def test_a_policy_is_searched_for_over_http(studio: Studio) -> None:
    small = {"scenarios": 1, "horizon_s": 1.0, "population": 4, "rounds": 1, "hidden": 2}
    body = {"scene": "asteroids", "optimiser": "hill-climbing", "name": "found", **small}
    assert result(studio, "/searches", body)["policy"] == "found"
    assert studio.client.get(f"{API}/policies/found").json()["learner"] is not None
    assert studio.client.delete(f"{API}/policies/found").status_code == 204


def test_people_walk_in_over_http(studio: Studio) -> None:
    steps = np.arange(40)
    rows = [f"{step} {who} {0.1 * step:.3f} {2.0 * who:.3f}" for who in (1, 2) for step in steps]
    table = "\n".join(["# fps=10", *rows])
    url = f"{API}/walks/two.txt"
    put = studio.client.put(url, content=table, headers={"Content-Type": "text/plain"})
    assert (put.status_code, put.json()["bytes"]) == (200, len(table))
    names = [one["name"] for one in studio.client.get(f"{API}/walks").json()["items"]]
    assert names == ["two.txt"]
    made = result(studio, "/imports", {"files": ["two.txt"], "people": 1, "session": "Two"})
    assert (made["name"], made["takes"]) == ("Two", 1)
    assert studio.client.delete(url).status_code == 204
    assert studio.client.delete(url).status_code == 404


@pytest.mark.parametrize(
    ("name", "content", "kind", "status"),
    [
        ("bad.txt", "nothing of the kind", "text/plain", 422),
        ("bad.exe", "# fps=10\n0 1 0 0", "text/plain", 422),
        ("bad.txt", "# fps=10\n0 1 0 0", "image/png", 415),
        ("..%2Fbad.txt", "# fps=10\n0 1 0 0", "text/plain", 404),
    ],
)
def test_what_is_no_recording_is_not_kept(
    studio: Studio, name: str, content: str, kind: str, status: int
) -> None:
    url = f"{API}/walks/{name}"
    answer = studio.client.put(url, content=content, headers={"Content-Type": kind})
    assert answer.status_code == status, answer.text
    assert not list(studio.workspace.root.rglob("bad*"))


@pytest.mark.parametrize(
    ("path", "body", "status", "says"),
    [
        ("/demonstrations", {"scene": "nowhere"}, 404, "no scene"),
        ("/demonstrations", {"scene": "asteroids", "pilot": "ghost"}, 404, "ghost"),
        ("/demonstrations", {"scene": "asteroids", "mark": "then"}, 422, "then"),
        ("/imports", {"files": ["ghost.txt"]}, 404, "ghost"),
        ("/imports", {"files": ["../studio.db"]}, 404, "studio.db"),
        ("/searches", {"scene": "asteroids", "name": "No Name"}, 422, "cannot be called"),
        ("/sessions/999/clean/preview", {}, 404, "no session"),
    ],
)
def test_what_cannot_be_made_is_refused_before_a_job_starts(
    studio: Studio, path: str, body: dict[str, Any], status: int, says: str
) -> None:
    answer = studio.client.post(API + path, json=body)
    assert answer.status_code == status
    assert says in answer.json()["detail"]


@pytest.mark.parametrize("path", ["/sessions", "/policies", "/scenes", "/pilots"])
def test_the_pages_of_a_list_make_the_whole(studio: Studio, path: str) -> None:
    for number in range(3):
        body = {"scene": "asteroids", "name": f"Paged {number}"}
        studio.client.post(f"{API}/sessions", json=body)
    whole = studio.client.get(API + path, params={"scene": "asteroids", "limit": 1000})
    assert whole.json()["next"] is None
    found: list[Any] = []
    cursor: dict[str, Any] = {}
    while True:
        page = studio.client.get(
            API + path, params={"scene": "asteroids", "limit": 2, **cursor}
        ).json()
        assert 1 <= len(page["items"]) <= 2
        found += page["items"]
        if page["next"] is None:
            break
        cursor = {"cursor": page["next"]}
    assert found == whole.json()["items"]


def test_the_worlds_of_an_evaluation_are_downloaded_as_arrays(studio: Studio) -> None:
    body = {"scene": "asteroids", "policies": ["straight"], "worlds": 3}
    made = result(studio, "/evaluations", body)
    url = f"{API}/evaluations/{made['evaluation']}/arrays"
    answer = studio.client.get(url)
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as arrays:
        assert all(len(array) == 3 for array in arrays.values())
        assert len(arrays) > 0
    again = studio.client.get(url, headers={"If-None-Match": answer.headers["etag"]})
    assert again.status_code == 304


def test_open_stages_are_listed_for_whoever_wants_to_watch(studio: Studio) -> None:
    made = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    assert made in studio.client.get(f"{API}/stages").json()["items"]
    studio.client.delete(f"{API}/stages/{made['id']}")
    assert made not in studio.client.get(f"{API}/stages").json()["items"]


def test_takes_are_paged_in_order(studio: Studio) -> None:
    made = headless.record(studio.workspace, "asteroids", minutes=0.1, session="Few", seed=3)
    url = f"{API}/sessions/{made['session']}/takes"
    whole = studio.client.get(url).json()["items"]
    first = studio.client.get(url, params={"limit": 1}).json()
    assert first["items"] == whole[:1]
    assert (first["next"] is None) == (len(whole) == 1)


def test_the_pairs_of_a_session_are_downloaded_as_learners_see_them(studio: Studio) -> None:
    made = headless.record(
        studio.workspace, "asteroids", "scripted:human", minutes=0.2, session="Pairs", seed=4
    )
    url = f"{API}/sessions/{made['session']}/pairs"
    plain = studio.client.get(url).json()
    assert len(plain["states"]) == len(plain["actions"]) == made["pairs"]
    assert (plain["steps"][:3], any(plain["conflicts"])) == ([0, 1, 2], False)
    lines = studio.client.get(url, params={"format": "csv"}).text.splitlines()
    assert len(lines) == made["pairs"] + 1
    flags = ["conflict", "correction"]
    assert lines[0].split(",") == ["take", "step", *flags, *plain["state"], *plain["action"]]
    arrays = studio.client.get(url, params={"format": "npz", "perception": "canonical"})
    with np.load(io.BytesIO(arrays.content), allow_pickle=False) as loaded:
        assert loaded["takes"].tolist() == plain["takes"]
    tag = arrays.headers["etag"]
    studio.client.post(f"{API}/takes/{plain['takes'][0]}/trash")
    again = studio.client.get(
        url, params={"format": "npz", "perception": "canonical"}, headers={"If-None-Match": tag}
    )
    assert again.status_code in {200, 422}
