"""A scene to draw, an app to serve it, and what viser's client would read from the wire."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator, Mapping, Sequence
from typing import Any, ClassVar

import msgspec
import numpy as np
import uvicorn
import zstandard
from fastapi import FastAPI, WebSocket
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

from evastudio.studio.mounted import SUBPROTOCOL
from evastudio.studio.view import View
from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box, Field

CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], dtype=np.float64)
SIDES = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])


class Slide(Scene):
    """A lit body and a shining one slide along x past posts that stand still."""

    name = "slide"
    title = "Slide"
    version = 1
    dt_s = 0.1
    render_hz = 30.0
    outcomes = ("running", "done")
    successes = frozenset({"done"})
    action = Box((Field("pull", "m", -1.0, 1.0),))
    perceptions: ClassVar[Mapping[str, Any]] = {}
    look = Look((10, 20, 30), 5.0, 50.0, (0.0, 0.0, 1.0))

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        posts = rng.normal(size=(worlds, 5, 3))
        return Snapshot({"posts": posts}, {"place": np.zeros((worlds, 3))})

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        return snapshot.after(place=snapshot["place"] + actions * (1.0, 0.0, 0.0))

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        return (snapshot["place"][:, 0] > 9.0).astype(np.int64)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.clip(snapshot["place"][:, 0] / 9.0, 0.0, 1.0)

    def meshes(self) -> Mapping[str, Mesh]:
        return {
            "lit": Mesh(CORNERS, SIDES, (200, 100, 50)),
            "lamp": Mesh(CORNERS, SIDES, (255, 255, 255), glow=True),
        }

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        posts, place = snapshot["posts"][0], snapshot["place"][:1]
        upright = np.array([[1.0, 0.0, 0.0, 0.0]])
        return [
            Body("posts", "lit", posts, np.repeat(upright, 5, axis=0), np.ones(5), fixed=True),
            Body("sled", "lit", place, upright, np.ones(1)),
            Body("lamp", "lamp", place, upright, np.ones(1)),
        ]

    def camera(self, snapshot: Snapshot) -> Camera:
        place = snapshot["place"][0]
        return Camera(place - (8.0, 0.0, 0.0), place, np.array([0.0, 0.0, 1.0]))


def at(x: float, seed: int = 0) -> Snapshot:
    """One world of `Slide`, `x` metres along."""
    start = Slide().worlds([seed])
    return start.after(place=start["place"] + np.array([x, 0.0, 0.0]))


@contextlib.asynccontextmanager
async def served(view: View, heard: bool = True) -> AsyncIterator[str]:
    """The address of `view`'s websocket on a server that runs within the block."""
    app = FastAPI()

    @app.websocket("/view")
    async def socket_of_view(websocket: WebSocket) -> None:
        await view.handle(websocket, heard)

    with socket.create_server(("127.0.0.1", 0)) as listening:
        server = uvicorn.Server(
            uvicorn.Config(app, ws="websockets-sansio", log_level="warning", lifespan="off")
        )
        serving = asyncio.create_task(server.serve(sockets=[listening]))
        try:
            yield f"ws://127.0.0.1:{listening.getsockname()[1]}/view"
        finally:
            view.close()
            server.should_exit = True
            await serving


def joined(address: str) -> connect:
    """A client of the view at `address`."""
    return connect(address, subprotocols=[Subprotocol(SUBPROTOCOL)], max_size=None)


async def window(client: ClientConnection) -> list[dict[str, Any]]:
    """The messages of the next window, which viser's client applies together."""
    raw = await client.recv(decode=False)
    size = int.from_bytes(raw[8:16], "little")
    inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size])
    messages: list[dict[str, Any]] = msgspec.msgpack.decode(inner)["messages"]
    return messages


async def replay(client: ClientConnection) -> list[dict[str, Any]]:
    """All that a browser gets which has just joined."""
    messages: list[dict[str, Any]] = []
    while not any(message["type"] == "ReplayDoneMessage" for message in messages):
        found = await window(client)
        messages += found
    return messages


async def drained(client: ClientConnection) -> None:
    """Read on until the connection closes, which raises ConnectionClosed."""
    while True:
        await client.recv()


def named(messages: Sequence[dict[str, Any]], kind: str, name: str | None = None) -> dict[str, Any]:
    """The one message of that type (and scene node) among `messages`."""
    (found,) = [m for m in messages if m["type"] == kind and name in (None, m.get("name"))]
    return found
