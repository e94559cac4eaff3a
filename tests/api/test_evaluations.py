"""Evaluations over HTTP: their pictures, made again, and who can be evaluated."""

from __future__ import annotations

from tests.api.jobs import result_of
from tests.conftest import Studio

API = "/api/v1"


def test_pictures_are_drawn_by_a_job_and_handed_out(studio: Studio) -> None:
    body = {"scene": "asteroids", "policies": ["straight"], "worlds": 2, "seed": 77}
    number = result_of(studio, studio.client.post(f"{API}/evaluations", json=body))["evaluation"]
    pictures = f"{API}/evaluations/{number}/pictures"
    before = studio.client.get(pictures).json()
    assert before == {"items": [], "left_out": None, "whole": False}
    assert studio.client.get(f"{pictures}/paths.svg").status_code == 404

    drawn = result_of(studio, studio.client.post(pictures))
    listed = studio.client.get(pictures).json()
    assert listed["whole"]
    assert [one["name"] for one in listed["items"]] == drawn["pictures"]
    for one in listed["items"]:
        svg, png = studio.client.get(one["svg"]), studio.client.get(one["png"])
        assert svg.headers["content-type"] == "image/svg+xml"
        assert svg.headers["content-disposition"].startswith("attachment")
        assert "<svg" in svg.text
        assert png.content.startswith(b"\x89PNG")
        again = studio.client.get(one["png"], headers={"If-None-Match": png.headers["etag"]})
        assert again.status_code == 304
    for wrong in ("drawn.json", "paths.gif", "..%2Fstudio.db"):
        assert studio.client.get(f"{pictures}/{wrong}").status_code == 404
    for method in ("get", "post"):
        missing = getattr(studio.client, method)(f"{API}/evaluations/999/pictures")
        assert (missing.status_code, missing.headers["content-type"]) == (
            404,
            "application/problem+json",
        )

    assert studio.client.get(f"{API}/evaluations/{number}/disputed").json() == {
        "worlds": [],
        "count": 0,
    }
    repeated = result_of(studio, studio.client.post(f"{API}/evaluations/{number}/again"))
    assert repeated["same"]


def test_whoever_can_act_in_a_scene_is_listed(studio: Studio) -> None:
    def names(scene: str) -> dict[str, str]:
        found = studio.client.get(f"{API}/pilots", params={"scene": scene}).json()["items"]
        return {one["name"]: one["kind"] for one in found}

    flying, walking = names("asteroids"), names("crowd")
    assert flying["asteroids-careful"] == walking["crowd-shy"] == "shipped"
    assert flying["astar"] == flying["scripted:careful"] == "program"
    assert "crowd-shy" not in flying
    assert "astar" not in walking
    assert {"scripted:shy", "scripted:startled"} <= walking.keys() - flying.keys()
    assert studio.client.get(f"{API}/pilots", params={"scene": "nowhere"}).status_code == 404
