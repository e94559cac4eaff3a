"""Headless worlds through the websocket: many steps on their way at once, each with its answer."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from evastudio.api import world_socket

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


def opened(studio: Studio, **body: Any) -> dict[str, Any]:
    answer = studio.client.post(f"{API}/worlds", json={"scene": "asteroids", **body})
    made: dict[str, Any] = answer.json()
    return made


def joined(studio: Studio, made: dict[str, Any], query: str = "") -> ClientConnection:
    url = studio.base.replace("http", "ws") + made["socket"] + query
    headers = {"Authorization": f"Bearer {studio.token}"}
    return connect(url, additional_headers=headers, proxy=None, max_size=None)


def rows(answer: str | bytes, worlds: int = 1) -> Any:
    assert isinstance(answer, bytes), answer
    return np.frombuffer(answer, "<f8").reshape(worlds, -1)


def test_many_steps_on_their_way_are_answered_in_order_and_as_over_http(studio: Studio) -> None:
    made, twin = (opened(studio, seeds=[3]) for _ in range(2))
    actions = np.random.default_rng(0).uniform(-0.05, 0.05, (200, 1, 2))
    with joined(studio, made) as socket:
        for action in actions:
            socket.send(action.tobytes())
        answers = [rows(socket.recv())[0] for _ in actions]
        socket.send(json.dumps({"do": "observe"}))
        assert np.array_equal(rows(socket.recv())[0], answers[-1])
    counts = [int(answer[2]) for answer in answers]
    assert counts == list(range(1, counts[-1] + 1)) + [counts[-1]] * (200 - counts[-1])
    path = f"{API}/worlds/{twin['id']}"
    body = {"actions": actions.tolist()}
    told = studio.client.post(f"{path}/step", json=body).json()
    last = answers[-1]
    assert made["outcomes"][int(last[0])] == told["outcomes"][0]
    assert [last[1], last[2]] == [told["progress"][0], told["steps"][0]]
    assert last[3:].tolist() == told["states"][0]
    studio.client.delete(path)


def test_a_crowd_steps_whole_or_by_its_lead_and_policies_play(studio: Studio) -> None:
    made = opened(studio, scene="crowd", seeds=[1, 2])
    size = len(made["action"])
    with joined(studio, made) as socket:
        socket.send(np.zeros((2, size)).tobytes())
        socket.send(np.zeros((3, 2, 60, size)).tobytes())
        socket.send(json.dumps({"do": "play", "pilot": "crowd-and-boulder", "steps": 2}))
        socket.send(json.dumps({"do": "reset", "seeds": [5]}))
        answers = [socket.recv() for _ in range(4)]
    assert [rows(answer, 2)[0, 2] for answer in answers[:3]] == [1, 4, 6]
    assert rows(answers[3]).shape == (1, 3 + 60 * len(made["state"]))
    studio.client.delete(f"{API}/worlds/{made['id']}")


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (b"", "0 bytes; expected a whole number of steps"),
        (b"1234567", "7 bytes"),
        (np.zeros(3).tobytes(), "16 bytes each"),
        (np.full(2, np.nan).tobytes(), "NaN"),
        (b"0" * (world_socket.MOST_BYTES + 16), "Send it over HTTP"),
        ("", "command"),
        ("{", "command"),
        ("[]", "command"),
        ('{"do": "dance"}', "dance"),
        ('{"do": "reset"}', "seeds"),
        ('{"do": "reset", "seeds": [-1]}', "seeds"),
        ('{"do": "play", "pilot": "ghost"}', "ghost"),
        ('{"do": "play", "pilot": "straight", "steps": 0}', "steps"),
    ],
)
def test_what_is_malformed_is_told_and_the_worlds_stay(
    studio: Studio, message: str | bytes, says: str
) -> None:
    made = opened(studio, seeds=[1])
    with joined(studio, made) as socket:
        socket.send(message)
        told = json.loads(socket.recv())
        assert told["status"] in {404, 422}
        assert says in told["detail"]
        socket.send(np.zeros((1, 2)).tobytes())
        assert rows(socket.recv())[0, 2] == 1
    studio.client.delete(f"{API}/worlds/{made['id']}")


def test_a_program_that_never_reads_is_not_read_from_and_the_worlds_stay(studio: Studio) -> None:
    """A thousand answers of 120 kB wait nowhere: the server stops reading, then goes on."""
    made = opened(studio, scene="crowd", seeds=[1, 2, 3])
    most = 2000
    with joined(studio, made) as socket:
        socket.socket.settimeout(1.0)
        sent = 0
        try:
            while sent < most:
                socket.send(json.dumps({"do": "observe"}) + " " * 100_000)
                sent += 1
        except (TimeoutError, ConnectionClosed):
            pass
        assert sent < most
    with joined(studio, made) as socket:
        socket.send(json.dumps({"do": "observe"}))
        assert rows(socket.recv(), 3)[:, 2].tolist() == [0, 0, 0]
    studio.client.delete(f"{API}/worlds/{made['id']}")


def test_a_lost_connection_leaves_the_worlds_as_they_are(studio: Studio) -> None:
    made = opened(studio, seeds=[1])
    socket = joined(studio, made, "?frame=own")
    socket.send(np.zeros((7, 1, 2)).tobytes())
    socket.recv()
    socket.socket.close()
    path = f"{API}/worlds/{made['id']}"
    assert studio.client.get(f"{path}/state").json()["steps"] == [7]
    with joined(studio, made) as again:
        studio.client.delete(path)
        again.send(np.zeros((1, 2)).tobytes())
        assert json.loads(again.recv())["status"] == 409
    with pytest.raises(InvalidStatus) as gone:
        joined(studio, made)
    assert gone.value.response.status_code == 404
    assert b"no batch of worlds" in (gone.value.response.body or b"")
