"""Clips over HTTP: files come in checked, and a choice is seen at once by who is watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.motion.walker import bvh, glb, walking

if TYPE_CHECKING:
    from conftest import Studio

CLIPS = "/api/v1/clips"


def test_a_file_is_kept_chosen_and_forgotten(studio: Studio) -> None:
    told = studio.client.put(f"{CLIPS}/files/hero.glb", content=glb(walking(1.2))).json()
    assert {"name": "hero.glb", "clips": ["walk"], "problem": None} in told["files"]
    assert (studio.workspace.motion / "hero.glb").is_file()
    chosen = studio.client.put(
        f"{CLIPS}/activities/walk", json={"file": "hero.glb", "clip": "walk"}
    ).json()
    walk = next(one for one in chosen["activities"] if one["name"] == "walk")
    assert (walk["file"], walk["clip"], walk["problem"]) == ("hero.glb", "walk", None)
    assert studio.client.get(CLIPS).json() == chosen
    told = studio.client.delete(f"{CLIPS}/activities/walk").json()
    assert all(one["file"] is None for one in told["activities"])


@pytest.mark.parametrize(
    ("name", "data", "match"),
    [
        ("broken.bvh", b"HIERARCHY", "no BVH file"),
        ("lies.bvh", bvh(walking(1.2)).replace("Frames: ", "Frames: 1000000000").encode(), "may"),
        ("short.glb", glb(walking(1.2))[:-8], "bytes, but has"),
        ("page.html", b"<html>", "no name for a file of clips"),
        (".hidden.bvh", b"", "no name for a file of clips"),
        ("clips.json", b"{}", "no name for a file of clips"),
        ("..%5Cout.bvh", b"", "no name for a file of clips"),
        ("a" * 300 + ".bvh", b"", "no name for a file of clips"),
    ],
)
def test_what_cannot_be_read_is_refused_and_not_kept(
    studio: Studio, name: str, data: bytes, match: str
) -> None:
    before = studio.client.get(CLIPS).json()
    answer = studio.client.put(f"{CLIPS}/files/{name}", content=data)
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert match in answer.json()["detail"]
    assert studio.client.get(CLIPS).json() == before


def test_a_file_too_large_is_refused_while_it_comes(studio: Studio) -> None:
    sent = 0

    def endless() -> object:
        nonlocal sent
        while sent < 80:
            sent += 1
            yield bytes(1_000_000)

    answer = studio.client.put(f"{CLIPS}/files/large.glb", content=endless())  # type: ignore[arg-type]
    assert answer.status_code == 413
    assert "larger" in answer.json()["detail"]
    assert not (studio.workspace.motion / "large.glb").exists()


@pytest.mark.parametrize(
    ("activity", "body", "status"),
    [
        ("fly", {"file": "hero.glb", "clip": "walk"}, 404),
        ("walk", {"file": "none.glb", "clip": "walk"}, 404),
        ("walk", {"file": "../hero.glb", "clip": "walk"}, 404),
        ("walk", {"file": "\0.glb", "clip": "walk"}, 422),
        ("walk", {"file": "hero.glb"}, 422),
    ],
)
def test_what_is_not_there_cannot_be_chosen(
    studio: Studio, activity: str, body: dict[str, str], status: int
) -> None:
    assert studio.client.put(f"{CLIPS}/activities/{activity}", json=body).status_code == status


def test_scenes_tell_whether_people_are_in_them(studio: Studio) -> None:
    told = {
        one["name"]: one["people"] for one in studio.client.get("/api/v1/scenes").json()["items"]
    }
    assert told["crowd"]
    assert not told["asteroids"]
