"""Flights: pages that demonstrate at a studio until it is gone, and keep what they were told."""

from __future__ import annotations

import asyncio
import contextlib
import json
from dataclasses import dataclass, field
from typing import Any

import httpx
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from benchmarks.soak.nursery import TOKEN, Child

HEADERS = {"Authorization": f"Bearer {TOKEN}"}
WAIT_S = 120.0
"""For a studio to answer, on a machine that has other things to do."""
SHORTEST_S = 0.6
"""A take that is ended lasts at least so long, so that it has pairs."""


@dataclass
class Flight:
    """What one page was told."""

    session: int
    restarts: bool
    """Whether it begins a new take now and then."""
    told: dict[int, int] = field(default_factory=dict)
    """Pairs of each take that was begun, as last told, by the seed of its world."""
    problem: str | None = None
    recording: asyncio.Event = field(default_factory=asyncio.Event)
    well: asyncio.Event = field(default_factory=asyncio.Event)
    """No problem is told."""

    async def fly(self, studio: Child, seed: int) -> None:
        """Demonstrate in the session until the connection breaks."""
        body = {"scene": "asteroids", "options": {"density": 0.5}, "seed": seed}
        body["session"] = self.session
        http = httpx.AsyncClient(
            base_url=studio.url, headers=HEADERS, trust_env=False, timeout=WAIT_S
        )
        async with http:
            answer = await http.post("/api/v1/stages", json=body)
            assert answer.is_success, answer.text
            stage = answer.json()
        url = studio.url.replace("http", "ws") + stage["socket"]
        with contextlib.suppress(WebSocketException, OSError):
            async with connect(url, additional_headers=HEADERS, proxy=None) as socket:
                await self._demonstrate(socket)

    async def _demonstrate(self, socket: ClientConnection) -> None:
        await socket.send(json.dumps({"type": "command", "name": "demonstrate"}))
        await socket.send(json.dumps({"type": "keys", "held": ["KeyW"], "time_ms": 0.0}))
        restarting = asyncio.create_task(self._restart(socket))
        try:
            async for text in socket:
                told = json.loads(text)
                if told["type"] == "status":
                    self._note(told)
        finally:
            restarting.cancel()

    def _note(self, told: dict[str, Any]) -> None:
        if told["phase"] == "recording":
            self.told[told["seed"]] = told["pairs"]
            if told["pairs"] > 0:
                self.recording.set()
        self.problem = told["problem"]
        (self.well.set if told["problem"] is None else self.well.clear)()

    async def _restart(self, socket: ClientConnection) -> None:
        with contextlib.suppress(WebSocketException):
            while self.restarts:
                await self.recording.wait()
                await asyncio.sleep(SHORTEST_S)
                self.recording.clear()
                await socket.send(json.dumps({"type": "command", "name": "restart"}))
