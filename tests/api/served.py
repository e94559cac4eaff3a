"""A studio within this process, so that its limits can be made small; and raw requests to one."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

import uvicorn
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from evastudio.server import configured, create_app
from evastudio.settings import Settings
from evastudio.workspace import Workspace

TOKEN = "a-token-for-tests-of-43-letters-or-so-1234567"
BEARER = {"Authorization": f"Bearer {TOKEN}"}


@contextlib.contextmanager
def within(folder: Path, **settings: str) -> Iterator[str]:
    """The address, without a slash at its end, of a studio that runs within the block."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        told = Settings(Workspace(folder), port=port, token=TOKEN, browser=False, **settings)  # type: ignore[arg-type]
        server = uvicorn.Server(configured(create_app(told, port), told))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            yield f"http://127.0.0.1:{port}"
        finally:
            server.should_exit = True
            thread.join()


def raw(base: str, sent: bytes) -> bytes:
    """All that comes back for those bytes until the server hangs up."""
    host, _, port = base.removeprefix("http://").partition(":")
    with socket.create_connection((host, int(port)), timeout=30.0) as wire:
        wire.sendall(sent)
        parts = []
        while part := wire.recv(65536):
            parts.append(part)
    return b"".join(parts)


def status(answer: bytes) -> int:
    """Of the first answer in `raw`'s bytes."""
    return int(answer.split(b" ", 2)[1])


def knock(url: str, headers: Mapping[str, str]) -> int:
    """The status that a websocket gets at its handshake."""

    async def attempt() -> int:
        try:
            async with connect(url, additional_headers=headers, proxy=None):
                return 101
        except InvalidStatus as error:
            return error.response.status_code

    return asyncio.run(attempt())
