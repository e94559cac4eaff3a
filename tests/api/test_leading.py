"""Leading one of many over HTTP: who is led, from where it is seen, and what the others do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from conftest import Studio

STAGES = "/api/v1/stages"


def test_a_program_chooses_the_lead_the_camera_and_the_others(studio: Studio) -> None:
    (scene,) = [
        one for one in studio.client.get("/api/v1/scenes").json()["items"] if one["name"] == "crowd"
    ]
    assert scene["many"]
    assert {one["name"]: one["placed"] for one in scene["signals"]} == {"drop": True, "mark": False}
    body = {"scene": "crowd", "options": {"people": 6}, "seed": 1}
    stage = studio.client.post(STAGES, json=body).json()

    def ask(**command: Any) -> Any:
        return studio.client.post(f"{STAGES}/{stage['id']}/commands", json=command)

    assert ask(name="camera").json()["camera"] == "overview"
    assert ask(name="camera", camera="chase").json()["camera"] == "chase"
    wrong = ask(name="camera", camera="chaise")
    assert (wrong.status_code, "chase" in wrong.json()["detail"]) == (404, True)
    assert ask(name="another").json()["lead"] == 1
    told = ask(name="demonstrate", others="scripted:shy").json()
    assert (told["phase"], told["others"], told["lead"]) == ("countdown", "scripted:shy", 1)
    again = ask(name="restart").json()
    assert (again["others"], again["seed"] != told["seed"]) == ("scripted:shy", True)
    assert ask(name="demonstrate", others="nobody").status_code == 404
