"""A viser server inside a running event loop, with no port of its own.

viser listens on a port that has no login and takes any Origin. Here its connections are handed
to it by the studio's front door, which has checked them. viser has no public way to do that, so
this file, and only this file, relies on private names of the viser version that pyproject.toml
pins; tests/studio/test_mounted.py fails when one of them changes.
"""

from __future__ import annotations

import asyncio
import inspect
import logging
import math
import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import rich
import viser
from starlette.websockets import WebSocket, WebSocketDisconnect
from viser import _messages, infra
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from websockets.exceptions import ConnectionClosedOK

from evastudio.live.pace import Pace

Point = tuple[float, float, float]
SUBPROTOCOL = f"viser-v{viser.__version__}"
"""What viser's own client asks for; it refuses a server of another version."""

LONGEST_MESSAGE = 4096
"""Bytes; where a browser looks from takes some three hundred."""
CAMERA = {
    "wxyz": 4,
    "position": 3,
    "look_at": 3,
    "up_direction": 3,
    "fov": 1,
    "near": 1,
    "far": 1,
    "image_height": 1,
    "image_width": 1,
}
"""What a browser tells of its camera, and how many numbers that is."""
PER_S, AT_ONCE = 200.0, 400.0
"""Messages from one browser; viser's client sends its camera at most some fifty times a second."""

_swapping = threading.Lock()
_log = logging.getLogger(__name__)


class Connection:
    """The three methods that viser needs of a websocket."""

    def __init__(self, websocket: WebSocket) -> None:
        self._websocket = websocket

    async def send(self, data: bytes) -> None:
        try:
            await self._websocket.send_bytes(data)
        except (WebSocketDisconnect, RuntimeError, OSError):
            raise ConnectionClosedOK(None, None) from None

    async def recv(self) -> bytes:
        try:
            return await self._websocket.receive_bytes()
        except (WebSocketDisconnect, RuntimeError, KeyError):
            raise ConnectionClosedOK(None, None) from None

    async def close(self, code: int = 1001, reason: str = "") -> None:
        try:
            await self._websocket.close(code, reason)
        except (WebSocketDisconnect, RuntimeError, OSError):
            return


class MountedSockets(infra.WebsockServer):
    """viser's websocket server without the listening socket."""

    def __init__(self, loop: asyncio.AbstractEventLoop, **options: Any) -> None:
        super().__init__(**options)
        self._background_event_loop = loop
        self._broadcast_buffer = AsyncMessageBuffer(loop, persistent_messages=True)
        self._joined = 0

    def start(self) -> None:
        """There is nothing to start: connections come through `handle`."""

    def stop(self) -> None:
        """Let every connection end. May be called from any thread, and after the loop's end."""
        self._broadcast_buffer.set_done()
        for state in list(self._client_state_from_id.values()):
            state.message_buffer.set_done()

    async def handle(self, websocket: WebSocket, heard: bool) -> None:
        """Serve one client until it leaves or the server stops; `heard` as `_listen` says."""
        if SUBPROTOCOL not in websocket.scope.get("subprotocols", ()):
            await websocket.close(1002, "Reload the page: it is of another version.")
            return
        await websocket.accept(subprotocol=SUBPROTOCOL)
        loop = asyncio.get_running_loop()
        client = infra.ClientId(self._joined)
        self._joined += 1
        wire: Any = Connection(websocket)
        state = _infra._ClientHandleState(AsyncMessageBuffer(loop, persistent_messages=False), loop)
        connection = infra.WebsockClientConnection(client, state)
        self._client_state_from_id[client] = state
        self._live_connections[client] = wire
        answering: set[asyncio.Task[None]] = set()

        async def answer(message: infra.Message) -> None:
            await self._handle_incoming_message(client, message)
            await connection._handle_incoming_message(client, message)

        def on_message(message: infra.Message) -> None:
            task = loop.create_task(answer(message))
            answering.add(task)
            task.add_done_callback(answering.discard)

        pumps: list[asyncio.Task[None]] = []
        try:
            await _call_all(self._client_connect_cb, connection)
            own, shared = state.message_buffer, self._broadcast_buffer
            done = self._backlog_done_message
            pumps = [
                loop.create_task(_infra._message_producer(wire, own, client)),
                loop.create_task(_infra._message_producer(wire, shared, client, done)),
                loop.create_task(_listen(wire, on_message if heard else None)),
            ]
            await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (*pumps, *answering):
                task.cancel()
            for ended in await asyncio.gather(*pumps, return_exceptions=True):
                if isinstance(ended, Exception) and not isinstance(ended, ConnectionClosedOK):
                    _log.error("A view lost its client: %s", ended, exc_info=ended)
            state.message_buffer.set_done()
            self._client_state_from_id.pop(client, None)
            self._live_connections.pop(client, None)
            shared.generator_cursors.pop(client, None)
            await _call_all(self._client_disconnect_cb, connection)
            await wire.close()


async def _listen(wire: Connection, heard: Callable[[infra.Message], None] | None) -> None:
    """Take in what a client sends until it leaves, floods, or sends what viser's never would.

    viser would act on whatever its own client could send: values of panels, clicks, files,
    requests for a public tunnel. The studio's page has its controls outside of viser, so all
    that is `heard` is where a browser looks from, and of one that only watches nothing.
    """
    loop = asyncio.get_running_loop()
    pace = Pace(PER_S, AT_ONCE)
    while True:
        raw = await wire.recv()
        if not pace.allows(loop.time()) or len(raw) > LONGEST_MESSAGE:
            await wire.close(1008, "Too much at once.")
            return
        if heard is None:
            continue
        try:
            message = _messages.Message.deserialize(raw)
            told = type(message) is _messages.ViewerCameraMessage and _finite(message)
        except Exception:  # of whatever kind: the bytes are anybody's
            await wire.close(1008, "This is no message of the view.")
            return
        if told:
            heard(message)


def _finite(camera: infra.Message) -> bool:
    """Whether a browser's camera is told in as many finite numbers as it takes."""
    for name, size in CAMERA.items():
        told = getattr(camera, name)
        parts = told if size > 1 else (told,)
        if len(parts) != size or not all(math.isfinite(part) for part in parts):
            return False
    return True


async def _call_all(
    callbacks: Sequence[Callable[[infra.WebsockClientConnection], Any]],
    connection: infra.WebsockClientConnection,
) -> None:
    for callback in callbacks:
        result = callback(connection)
        if inspect.isawaitable(result):
            await result


class MountedViser(viser.ViserServer):
    """A viser server whose clients come through `handle`.

    Handles may be changed from any thread; `handle` runs on the loop.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, label: str | None = None) -> None:
        """A server for clients of `loop`, which must be running when they connect."""
        # viser looks its websocket server up by name while it is built, and prints an address
        # that does not exist here; capture() takes up what this thread prints, no other.
        with _swapping, rich.get_console().capture():
            original = infra.WebsockServer
            infra.WebsockServer = partial(MountedSockets, loop)  # type: ignore[assignment,misc]
            try:
                super().__init__(host="127.0.0.1", port=0, label=label, verbose=False)
            finally:
                infra.WebsockServer = original  # type: ignore[misc]
        if not isinstance(self._websock_server, MountedSockets):
            raise RuntimeError(f"viser {viser.__version__} cannot be mounted; it opened a port.")
        self._sockets: MountedSockets = self._websock_server
        # Any client may ask viser for a public tunnel to this server, button or no button.
        for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
            self._sockets._incoming_handlers.pop(message)
        self._up: tuple[float, ...] = ()

    async def handle(self, websocket: WebSocket, heard: bool = True) -> None:
        """Serve a websocket whose right to be here has been checked, until it closes.

        Unless `heard`, nothing that the browser sends is looked at.
        """
        await self._sockets.handle(websocket, heard)

    @property
    def clients(self) -> int:
        """Number of connected clients."""
        return len(self._sockets._live_connections)

    def set_pose(self, name: str, position: Sequence[float], wxyz: Sequence[float]) -> None:
        """Move the scene node `name` to three finite metres and a unit quaternion.

        The setters of viser's handles do the same, but leave out changes below a hundredth of a
        thousandth of the distance, and take several times as long.
        """
        queue = self._sockets.queue_message
        queue(_messages.SetPositionMessage(name, (position[0], position[1], position[2])))
        queue(_messages.SetOrientationMessage(name, (wxyz[0], wxyz[1], wxyz[2], wxyz[3])))

    def set_camera(self, position: Point, look_at: Point, up: Point) -> None:
        """Move every client's camera, in order with the scene's own messages.

        viser's `client.camera` uses a queue of its own, so that camera and scene arrive apart.
        """
        queue = self._sockets.queue_message
        if up != self._up:
            self._up = up
            queue(_messages.SetCameraUpDirectionMessage(up))
        queue(_messages.SetCameraPositionMessage(position))
        queue(_messages.SetCameraLookAtMessage(look_at))

    def close(self) -> None:
        """End every connection and let go of viser's threads. May be called twice."""
        self.stop()


def mounted_viser(loop: asyncio.AbstractEventLoop, label: str | None = None) -> MountedViser:
    """A viser server inside `loop`, with no port."""
    return MountedViser(loop, label)
