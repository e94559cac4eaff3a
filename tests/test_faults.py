"""A killed server loses at most the last half second of a take, and the store just opens."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from websockets.asyncio.client import connect

from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live.headless import make_scene

if TYPE_CHECKING:
    from conftest import Studio

LOSS_S = 0.5


async def record_until(studio: Studio, stage: dict[str, Any], pairs: int) -> tuple[int, float]:
    """Record until the stage tells of `pairs` pairs; how many, and when it told so."""
    headers = {"Authorization": f"Bearer {studio.token}"}
    url = studio.base.replace("http", "ws") + stage["socket"]
    async with connect(url, additional_headers=headers, proxy=None) as socket:
        await socket.send(json.dumps({"type": "command", "name": "demonstrate"}))
        await socket.send(json.dumps({"type": "keys", "held": ["KeyW"], "time_ms": 0.0}))
        while True:
            told = json.loads(await socket.recv())
            if told.get("phase") == "recording" and told["pairs"] >= pairs:
                return told["pairs"], time.monotonic()


@pytest.mark.parametrize("pairs", [20, 47])
def test_a_killed_server_loses_at_most_half_a_second(
    start_studio: Callable[..., Studio], pairs: int
) -> None:
    studio = start_studio()
    body = {"scene": "asteroids", "options": {"density": 0.5}, "seed": 11}
    stage = studio.client.post("/api/v1/stages", json=body).json()
    told, at = asyncio.run(record_until(studio, stage, pairs))
    studio.kill()
    killed_after = time.monotonic() - at

    again = start_studio(studio.workspace)
    session = again.client.get("/api/v1/sessions").json()["items"][0]
    take = again.client.get(f"/api/v1/sessions/{session['id']}/takes").json()["items"][0]
    dt_s = again.client.get("/api/v1/scenes/asteroids").json()["dt_s"]
    assert take["outcome"] is None
    assert take["pairs"] * dt_s >= told * dt_s - LOSS_S
    assert take["pairs"] <= told + (killed_after + 0.2) / dt_s

    with Store(studio.workspace.store_url) as store:
        record, data = store.take(take["id"]), store.load_take(take["id"])
    assert len(data.actions) == take["pairs"]
    scene = make_scene(studio.workspace, "asteroids", record.options)
    replayed = replay_take(scene, record, data)
    for name in data.snapshots.moving:
        assert np.array_equal(replayed[name], data.snapshots[name])


def test_sigterm_keeps_the_running_take_whole(start_studio: Callable[..., Studio]) -> None:
    studio = start_studio()
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids", "seed": 3}).json()
    told, _ = asyncio.run(record_until(studio, stage, 10))
    assert studio.stop() == 0
    with Store(studio.workspace.store_url) as store:
        assert store.sessions()[0].pairs >= told
