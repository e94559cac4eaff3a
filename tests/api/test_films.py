"""Films over HTTP: made by a job of a take or of what a stage shows, and handed out as files."""

from __future__ import annotations

import io
import os

import av

from tests.api.jobs import result_of
from tests.conftest import Studio

API = "/api/v1"


def test_a_take_is_made_into_a_video_and_a_page(studio: Studio) -> None:
    client = studio.client
    made = {"scene": "asteroids", "name": "To be shown"}
    session = client.post(f"{API}/sessions", json=made).json()["id"]
    take = client.post(f"{API}/sessions/{session}/takes", json={"seed": 1}).json()["take"]
    empty = client.post(f"{API}/takes/{take}/film", json={})
    assert (empty.status_code, "Nothing was recorded" in empty.json()["detail"]) == (409, True)
    actions = {"first_step": 0, "actions": [[0.05, 0.02]] * 15}
    client.post(f"{API}/takes/{take}/actions", json=actions).raise_for_status()

    video = {"form": "mp4", "width": 160, "height": 90, "camera": "far"}
    done = result_of(studio, client.post(f"{API}/takes/{take}/film", json=video))
    assert done["film"] == f"asteroids-take-{take}.mp4"
    got = client.get(f"{API}/films/{done['film']}")
    assert got.headers["content-type"] == "video/mp4"
    assert got.headers["content-disposition"].startswith("attachment")
    with av.open(io.BytesIO(got.content)) as container:
        assert sum(1 for _ in container.decode(video=0)) == 31
    again = {"If-None-Match": got.headers["etag"]}
    assert client.get(f"{API}/films/{done['film']}", headers=again).status_code == 304

    page = result_of(studio, client.post(f"{API}/takes/{take}/film", json={}))["film"]
    html = client.get(f"{API}/films/{page}")
    assert html.headers["content-type"] == "text/html; charset=utf-8"
    assert html.headers["content-disposition"].startswith("attachment")
    names = [one["name"] for one in client.get(f"{API}/films").json()["items"]]
    assert {done["film"], page} <= set(names)
    assert client.delete(f"{API}/films/{page}").status_code == 204
    assert client.get(f"{API}/films/{page}").status_code == 404
    for wrong in ({"form": "gif"}, {"width": 161}, {"camera": "behind"}):
        assert client.post(f"{API}/takes/{take}/film", json=wrong).status_code == 422
    assert client.get(f"{API}/films/..%2Fstudio.db").status_code == 404


def test_a_film_that_is_deleted_while_it_is_sent_arrives_whole(studio: Studio) -> None:
    content = os.urandom(24_000_000)  # more than the sockets between us hold
    (studio.workspace.films / "large.mp4").write_bytes(content)
    address = f"{API}/films/large.mp4"
    with studio.client.stream("GET", address) as answer:
        assert answer.headers["content-length"] == str(len(content))
        pieces = answer.iter_raw()
        got = next(pieces)
        assert studio.client.delete(address).status_code == 204
        got += b"".join(pieces)
    assert got == content
    assert studio.client.get(address).status_code == 404


def test_a_stage_on_which_nothing_moved_has_no_film(studio: Studio) -> None:
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids", "seed": 1}).json()["id"]
    none = studio.client.post(f"{API}/stages/{stage}/film", json={})
    assert (none.status_code, "Nothing has moved" in none.json()["detail"]) == (409, True)
    studio.client.delete(f"{API}/stages/{stage}")
