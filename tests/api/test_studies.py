"""Studies over HTTP: kept from a session's takes, gone on with, and forgotten."""

from __future__ import annotations

from tests.conftest import Studio

API = "/api/v1"


def test_a_study_tells_how_long_a_session_took(studio: Studio) -> None:
    client = studio.client
    made = {"scene": "asteroids", "name": "Of somebody who agreed"}
    session = client.post(f"{API}/sessions", json=made).json()["id"]

    def fly(steps: int) -> None:
        take = client.post(f"{API}/sessions/{session}/takes", json={"seed": 1}).json()["take"]
        actions = {"first_step": 0, "actions": [[0.0, 0.0]] * steps}
        client.post(f"{API}/takes/{take}/actions", json=actions).raise_for_status()

    fly(30)
    body = {"session": session, "person": "artist", "instructed_s": 90.5}
    kept = client.post(f"{API}/studies", json=body)
    assert kept.status_code == 201
    told = kept.json()
    study = f"{API}/studies/{told['id']}"
    assert told["scene"] == "asteroids"
    assert (told["instructed_s"], told["demonstrated_s"]) == (90.5, 2.0)

    fly(15)
    again = client.put(study, json={**body, "preferred": "their own"}).json()
    assert (again["id"], again["demonstrated_s"]) == (told["id"], 3.0)
    assert again in client.get(f"{API}/studies").json()["items"]

    assert client.delete(study).status_code == 204
    assert told["id"] not in [one["id"] for one in client.get(f"{API}/studies").json()["items"]]
    for missing in (client.delete(study), client.put(study, json=body)):
        assert missing.status_code == 404
    nobodys = client.post(f"{API}/studies", json={**body, "session": 999_999})
    assert nobodys.status_code == 404
