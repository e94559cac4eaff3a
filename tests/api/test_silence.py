"""A page that falls silent in the middle of a hold holds nothing."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any

from evastudio.demonstrations.store import Store
from tests.api.test_routes import API, drive, in_phase, until

if TYPE_CHECKING:
    from conftest import Studio

GOOD_MS = 400.0


def test_keys_are_released_where_nothing_more_is_heard(studio: Studio) -> None:
    """As where a network fails without a word: the connection stays open, and nothing comes."""
    body = {"scene": "asteroids", "name": "Silent"}
    session = studio.client.post(f"{API}/sessions", json=body).json()["id"]
    asked = {"scene": "asteroids", "seed": 6, "session": session, "options": {"density": 0.1}}
    stage = studio.client.post(f"{API}/stages", json=asked).json()
    pairs: list[int] = []

    async def fly() -> None:
        async with drive(studio, stage) as socket:

            async def hold(*keys: str, **more: Any) -> None:
                told = {"type": "keys", "held": keys, "time_ms": 0.0, "seq": len(pairs), **more}
                await socket.send(json.dumps(told))
                await until(socket, lambda one: one == {"type": "ack", "seq": len(pairs)})

            async def recorded(more: int) -> None:
                now = pairs[-1] if pairs else 0
                told = await until(socket, lambda one: one.get("pairs", 0) >= now + more)
                pairs.append(told["pairs"])

            await socket.send(json.dumps({"type": "command", "name": "demonstrate"}))
            await until(socket, in_phase("recording"))
            await hold("KeyA", for_ms=GOOD_MS)
            await recorded(75)  # silent for five seconds by now
            await hold("KeyW", for_ms=GOOD_MS)
            await hold("KeyW")  # by a program, which need not say so again
            await recorded(30)

    asyncio.run(fly())
    with Store(studio.workspace.store_url) as store:
        actions = store.load_take(store.takes(session)[0].id).actions
    left, climb = actions.T
    assert left.max() > 0.05
    assert (left[pairs[0] - 3 : pairs[0]] == 0.0).all()
    assert (climb[pairs[1] - 3 : pairs[1]] > 0.05).all()
