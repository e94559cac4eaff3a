"""Two studios, processes of their own, record into one session of one store at once."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live.headless import make_scene
from evastudio.workspace import Workspace
from tests.test_faults import STAGE, at_stage, recorded, until

if TYPE_CHECKING:
    from conftest import Studio

PAIRS = 25
STAGES = 2
"""Of each studio."""


async def demonstrate(studio: Studio, session: int) -> int:
    """Record a take into the session; how many pairs the studio says it has."""
    asked = {**STAGE, "session": session}
    answer = await asyncio.to_thread(studio.client.post, "/api/v1/stages", json=asked)
    stage = answer.raise_for_status().json()
    async with at_stage(studio, stage) as socket:
        await until(socket, recorded(PAIRS))
        await socket.send(json.dumps({"type": "command", "name": "pause"}))
        told = await until(socket, lambda told: told["phase"] == "paused")
    closed = await asyncio.to_thread(studio.client.delete, f"/api/v1/stages/{stage['id']}")
    assert closed.status_code == 204
    return int(told["pairs"])


def test_two_studios_record_into_one_session_and_lose_nothing(
    start_studio: Callable[..., Studio], store_url: str, tmp_path: Path
) -> None:
    studios = [start_studio(Workspace(tmp_path / name, store_url)) for name in ("one", "other")]
    named = {"scene": "asteroids", "name": "Together", "demonstrator": "two"}
    session = studios[0].client.post("/api/v1/sessions", json=named).raise_for_status().json()["id"]

    async def all_of_them() -> list[int]:
        return await asyncio.gather(
            *(demonstrate(studio, session) for studio in studios for _ in range(STAGES))
        )

    told = asyncio.run(all_of_them())
    for studio in studios:
        seen = studio.client.get(f"/api/v1/sessions/{session}").json()
        assert (seen["takes_kept"], seen["pairs"]) == (len(told), sum(told))
    with Store(store_url) as store:
        takes = store.takes(session)
        assert sorted(take.number for take in takes) == [1, 2, 3, 4]
        assert sorted(take.pairs for take in takes) == sorted(told)
        for take in takes:
            data = store.load_take(take.id)
            scene = make_scene(studios[0].workspace, "asteroids", take.options)
            again = replay_take(scene, take, data)
            assert np.array_equal(data.snapshots["steps"], np.arange(take.pairs))
            assert all(np.array_equal(again[name], data.snapshots[name]) for name in again.moving)
