"""Looking back over HTTP: what takes look like, what is odd about them, and what a run shows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


@pytest.fixture
def session(studio: Studio) -> int:
    body = {"scene": "asteroids", "name": "By program"}
    made: int = studio.client.post(f"{API}/sessions", json=body).json()["id"]
    return made


def take(studio: Studio, session: int, steps: int) -> int:
    """One of so many steps straight ahead."""
    made = studio.client.post(f"{API}/sessions/{session}/takes", json={"seed": 3}).json()["take"]
    actions = {"first_step": 0, "actions": [[0.0, 0.0]] * steps}
    assert studio.client.post(f"{API}/takes/{made}/actions", json=actions).status_code == 200
    return int(made)


def test_a_thumbnail_is_read_once_until_the_take_is_another(studio: Studio, session: int) -> None:
    made = take(studio, session, 20)
    address = f"{API}/takes/{made}/thumbnail.svg"
    first = studio.client.get(address)
    assert first.status_code == 200
    assert first.headers["content-type"].startswith("image/svg+xml")
    assert first.text.startswith("<svg")
    named = {"If-None-Match": first.headers["etag"]}
    assert studio.client.get(address, headers=named).status_code == 304
    more = {"first_step": 20, "actions": [[0.0, 0.0]] * 20}
    studio.client.post(f"{API}/takes/{made}/actions", json=more)
    assert studio.client.get(address, headers=named).status_code == 200
    empty = studio.client.post(f"{API}/sessions/{session}/takes", json={}).json()["take"]
    assert studio.client.get(f"{API}/takes/{empty}/thumbnail.svg").status_code == 404


def test_takes_come_newest_first_in_pages_where_wanted(studio: Studio, session: int) -> None:
    made = [take(studio, session, 1) for _ in range(5)]
    seen: list[int] = []
    cursor: dict[str, Any] = {}
    while True:
        query = {"newest": True, "limit": 2, **cursor}
        page = studio.client.get(f"{API}/sessions/{session}/takes", params=query).json()
        seen += [one["id"] for one in page["items"]]
        if page["next"] is None:
            break
        cursor = {"cursor": page["next"]}
    assert seen == made[::-1]


def test_what_is_odd_about_takes_is_told_in_words(studio: Studio, session: int) -> None:
    short, still = take(studio, session, 10), take(studio, session, 60)
    told = studio.client.get(f"{API}/sessions/{session}/remarks").json()["items"]
    assert {one["take"]: [remark["kind"] for remark in one["remarks"]] for one in told} == {
        short: ["short", "still"],
        still: ["still"],
    }
    assert told[0]["remarks"][0]["says"] == "Nothing was steered."
    assert studio.client.get(f"{API}/sessions/999/remarks").status_code == 404


def test_a_take_is_looked_back_at_cut_and_left(studio: Studio, session: int) -> None:
    made = take(studio, session, 60)
    body = {"scene": "asteroids", "session": session, "seed": 1}
    stage = studio.client.post(f"{API}/stages", json=body).json()["id"]

    def ask(**command: Any) -> Any:
        return studio.client.post(f"{API}/stages/{stage}/commands", json=command)

    assert ask(name="leave").status_code == 409
    told = ask(name="review", take=made, seconds=2.0).json()
    assert (told["phase"], told["take"], told["seed"]) == ("reviewing", made, 3)
    strip = studio.client.get(f"{API}/stages/{stage}/strip").json()
    assert (strip["first_s"], strip["length_s"]) == (0.0, pytest.approx(4.0))
    assert strip["familiarity"] == [None] * 60
    refused = ask(name="restart")
    assert refused.status_code == 409
    assert "looking back" in refused.json()["detail"]

    kept = ask(name="keep-last", take=made, seconds=2.0).json()
    assert (kept["phase"], kept["length_s"]) == ("reviewing", pytest.approx(2.0))
    cut = studio.client.get(f"{API}/takes/{kept['take']}").json()
    assert (cut["pairs"], cut["origin"]["number"], cut["origin"]["seconds"]) == (30, 1, 2.0)
    assert studio.client.get(f"{API}/takes/{made}").json()["trashed"]
    assert ask(name="leave").json()["phase"] == "ready"
