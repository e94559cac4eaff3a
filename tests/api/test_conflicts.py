"""Conflicts over HTTP: looked for, listed at any threshold, judged, and shown on a stage."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tests.api.test_making import result

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


def test_conflicts_are_looked_for_listed_judged_and_shown(studio: Studio) -> None:
    body = {"scene": "asteroids", "pilot": "scripted:human", "minutes": 0.5, "session": "Shown"}
    session = result(studio, "/demonstrations", body)["session"]
    root = f"{API}/sessions/{session}"

    def get(path: str, **query: Any) -> Any:
        return studio.client.get(root + path, params=query)

    unseen = get("/conflicts")
    assert (unseen.status_code, unseen.json()) == (200, None)
    assert studio.client.get(f"{API}/sessions/{session + 1}/conflicts").status_code == 404
    seen = result(studio, f"/sessions/{session}/clean/preview", {"worst": 0})
    told = get("/conflicts").json()
    assert told["goes"] == told["conflicts"] == seen["removed"] > 0
    assert not told["stale"]
    strict = get("/conflicts", threshold=0.05, limit=3).json()
    assert strict["goes"] > told["goes"]
    assert len(strict["items"]) == 3
    for wrong in ("0", "nan", "loose", "11"):
        assert get("/conflicts", threshold=wrong).status_code == 422

    first = told["items"][0]
    moment = f"{first['take']}/{first['step']}"
    beside = get(f"/conflicts/{moment}").json()
    assert beside["conflict"] == first
    assert len(beside["neighbors"]) == told["neighbors"]
    assert get(f"/conflicts/{first['take']}/999999").status_code == 404

    put = studio.client.put(f"{root}/verdicts/{moment}", json={"verdict": "missing"})
    assert put.json() == {"take": first["take"], "step": first["step"], "verdict": "missing"}
    assert get("/verdicts").json() == {"items": [put.json()]}
    assert get("/conflicts").json()["goes"] == told["goes"] - 1
    wrong_verdict = studio.client.put(f"{root}/verdicts/{moment}", json={"verdict": "perhaps"})
    assert wrong_verdict.status_code == 422
    other = studio.client.post(f"{API}/sessions", json={"scene": "asteroids", "name": "Other"})
    elsewhere = f"{API}/sessions/{other.json()['id']}/verdicts/{moment}"
    assert studio.client.put(elsewhere, json={"verdict": "keep"}).status_code == 404
    assert studio.client.delete(f"{root}/verdicts/{moment}").status_code == 204
    assert get("/verdicts").json() == {"items": []}

    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()["id"]
    command = {"name": "compare", "take": first["take"], "step": first["step"]}
    status = studio.client.post(f"{API}/stages/{stage}/commands", json=command).json()
    assert (status["mode"], status["take"]) == ("review", first["take"])
    nothing = studio.client.post(f"{API}/stages/{stage}/commands", json={"name": "compare"})
    assert nothing.status_code == 422
