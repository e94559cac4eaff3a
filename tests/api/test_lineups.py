"""Lineups and ballots over HTTP: whose they are, and what is not told before somebody has voted."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import httpx
import pytest

from evastudio.demonstrations.store import Store
from evastudio.evaluation import preferences
from evastudio.live.tokens import Role
from tests.api.test_roles import client_of, let_in

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
TWO = ["scripted:careful", "straight"]


@pytest.fixture(scope="module")
def viewer(studio: Studio) -> Iterator[httpx.Client]:
    with client_of(studio, let_in(studio, "Viola", Role.VIEWER)) as client:
        client.timeout = httpx.Timeout(60.0)
        yield client


def shown(client: httpx.Client, pilots: list[str] = TWO, **more: Any) -> dict[str, Any]:
    body = {
        "scene": "asteroids",
        "options": {"density": 2.0},
        "entrants": [{"pilot": name} for name in pilots],
        **more,
    }
    answer = client.post(f"{API}/lineups", json=body)
    assert answer.status_code == 201, answer.text
    told: dict[str, Any] = answer.json()
    return told


def test_a_lineup_is_flown_moved_and_closed(viewer: httpx.Client, studio: Studio) -> None:
    lineup = shown(viewer, seed=5, world=2)
    address = f"{API}/lineups/{lineup['id']}"
    assert [column["title"] for column in lineup["columns"]] == TWO
    assert lineup["parts_s"] == lineup["columns"][1]["parts_s"] > 0.0
    assert lineup["length_s"] == max(column["length_s"] for column in lineup["columns"])
    assert lineup["columns"][0]["happenings"][-1]["kind"] == "outcome"
    for column in lineup["columns"]:
        assert "canvas" in viewer.get(column["view"]).text
    stood = viewer.post(f"{address}/commands", json={"name": "seek", "seconds": 1.0}).json()
    assert (stood["position_s"], stood["speed"], stood["turned"]) == (1.0, 0.0, False)
    rolling = viewer.post(f"{address}/commands", json={"name": "roll", "speed": 0.5}).json()
    assert rolling["speed"] == 0.5
    assert viewer.get(f"{address}/standing").json()["position_s"] >= 1.0
    wrong = viewer.post(f"{address}/commands", json={"name": "camera", "camera": "nowhere"})
    assert wrong.status_code == 404

    # Nobody else's to see or to stop.
    assert studio.client.get(f"{API}/lineups").json()["items"] == []
    assert studio.client.delete(address).status_code == 404
    assert [one["id"] for one in viewer.get(f"{API}/lineups").json()["items"]] == [lineup["id"]]
    assert viewer.delete(address).status_code == 204
    assert viewer.get(address).status_code == 404
    assert viewer.get(lineup["columns"][0]["view"]).status_code == 404


def test_what_cannot_be_shown_is_refused_in_a_sentence(viewer: httpx.Client) -> None:
    for entrants in (
        [{"pilot": "straight"}],
        [{"pilot": "straight"}] * 5,
        [{"pilot": "straight"}, {}],
        [{"pilot": "straight"}, {"take": 987654}],
        [{"pilot": "straight"}, {"pilot": "crowd-shy"}],
    ):
        body = {"scene": "asteroids", "entrants": entrants}
        assert viewer.post(f"{API}/lineups", json=body).status_code in {404, 409, 422}


def test_a_vote_is_blind_kept_once_and_counted(viewer: httpx.Client, studio: Studio) -> None:
    author = studio.client
    body = {"scene": "asteroids", "pilots": TWO, "options": {"density": 2.0}, "seed": 9}
    assert viewer.post(f"{API}/ballots", json=body).status_code == 403
    ballot = author.post(f"{API}/ballots", json=body).json()
    address = f"{API}/ballots/{ballot['id']}"
    assert (ballot["votes"], ballot["mine"]) == (0, 0)

    # Everything a viewer is told before the vote, headers too.
    told = [viewer.get(path) for path in (f"{API}/ballots", address, f"{API}/me")]
    told.append(viewer.get(f"{address}/preference"))
    assert told[-1].status_code == 409
    told += [viewer.get(f"{API}/ballots/{what}") for what in ("preferences", "table-3")]
    told.append(viewer.post(f"{address}/showings"))
    lineup = told[-1].json()
    assert [column["title"] for column in lineup["columns"]] == ["Left", "Right"]
    told += [viewer.get(f"{API}/lineups/{lineup['id']}"), viewer.get(f"{API}/lineups")]
    # Asked again before the vote they stand as they stood.
    told.append(viewer.post(f"{address}/showings"))
    again = told[-1].json()
    assert (again["world"], again["columns"][0]["length_s"]) == (
        lineup["world"],
        lineup["columns"][0]["length_s"],
    )
    for answer in told:
        for name in (*TWO, "careful"):
            assert name not in answer.text.replace("scripted demonstrators", "")
            assert name not in str(answer.headers)

    sides = ("left", "right")
    longest = max(sides, key=lambda side: lineup["columns"][sides.index(side)]["length_s"])
    vote = {"lineup": lineup["id"], "livelier": longest}
    cast = viewer.post(f"{address}/votes", json=vote).json()
    assert cast["livelier"] == cast[longest] == "scripted:careful"
    assert {cast["left"], cast["right"]} == set(TWO)
    assert cast["preference"]["votes"] == [1, 0]
    assert cast["preference"]["interval"][0] < 0.5
    assert viewer.post(f"{address}/votes", json=vote).status_code == 409
    other = {"lineup": again["id"], "livelier": "left"}
    assert viewer.post(f"{address}/votes", json=other).status_code == 409
    assert viewer.get(f"{address}/preference").json() == cast["preference"]
    assert (
        "| asteroids | scripted:careful | straight | 1 to 0 | 0 | 1 |"
        in viewer.get(f"{API}/ballots/table-3").text
    )

    # The next two are in another world, and an author sees what came of it.
    following = viewer.post(f"{address}/showings").json()
    assert following["world"] == 1
    none = {"lineup": following["id"], "livelier": "neither"}
    assert viewer.post(f"{address}/votes", json=none).json()["livelier"] is None
    found = author.get(f"{address}/preference").json()
    assert (found["votes"], found["neither"], found["people"]) == ([1, 0], 1, 1)
    mine = author.get(address).json()
    assert (mine["votes"], mine["mine"]) == (2, 0)
    newer = author.post(f"{API}/ballots", json=body).json()["id"]
    page = author.get(f"{API}/ballots/preferences", params={"limit": 1}).json()
    assert page == {"items": [], "next": newer}, "nobody has voted on the newest"
    page = author.get(f"{API}/ballots/preferences", params={"cursor": newer}).json()
    assert page["items"][0] == viewer.get(f"{address}/preference").json()
    theirs = shown(viewer)
    wrong = {"lineup": theirs["id"], "livelier": "left"}
    assert viewer.post(f"{address}/votes", json=wrong).status_code == 409
    assert viewer.delete(address).status_code == 403
    assert author.delete(address).status_code == 204
    assert author.get(address).status_code == 404


def test_only_two_different_ones_that_can_act_are_asked_about(studio: Studio) -> None:
    for pilots in (["straight", "straight"], ["straight", "crowd-shy"], ["straight"]):
        body = {"scene": "asteroids", "pilots": pilots}
        assert studio.client.post(f"{API}/ballots", json=body).status_code in {409, 422}


def test_a_ballot_whose_scene_is_gone_hides_no_others(studio: Studio) -> None:
    gone = {"name": "gone", "version": 1, "options": {}}
    with Store(studio.workspace.store_url) as store:
        made = preferences.open_ballot(store, gone, {"straight": None, "mine": "ab12"}, 1, 2.0).id
    (told,) = studio.client.get(f"{API}/ballots", params={"scene": "gone"}).json()["items"]
    assert told == studio.client.get(f"{API}/ballots/{made}").json()
    assert (told["scene"], told["title"]) == ("gone", "gone")
    shown = studio.client.post(f"{API}/ballots/{made}/showings")
    assert (shown.status_code, "ask anew" in shown.json()["detail"]) == (409, True)
    assert studio.client.delete(f"{API}/ballots/{made}").status_code == 204
