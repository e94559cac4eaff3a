"""Hostile websockets: floods, giant frames, and what is no message. Each by its name."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import socket
import struct
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import msgspec
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from evastudio.api import limits
from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Role, Tokens
from tests.api.served import BEARER, within
from tests.studio.drawn import drained
from tests.studio.test_heard import CAMERA, OTHERS

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
VIEW = "viser-v1.1.1"
GONE = 1006


@pytest.fixture
def stage(studio: Studio) -> Iterator[Mapping[str, str]]:
    opened = studio.client.post(f"{API}/stages", json={"scene": "asteroids", "seed": 1}).json()
    yield opened
    assert studio.client.get(f"{API}/stages/{opened['id']}").json()["phase"] == "ready"
    studio.client.delete(f"{API}/stages/{opened['id']}")


def joined(studio: Studio, path: str, token: str | None = None) -> connect:
    headers = {"Authorization": f"Bearer {token or studio.token}"}
    return connect(
        studio.base.replace("http", "ws") + path,
        additional_headers=headers,
        proxy=None,
        max_size=None,
        subprotocols=[VIEW] if path.startswith("/view/") else None,  # type: ignore[list-item]
    )


async def cut(client: ClientConnection, *messages: str | bytes) -> int:
    """The code with which the server hangs up on whoever sends that.

    GONE where it was still being sent, so that the code did not arrive.
    """
    with pytest.raises(ConnectionClosed) as closed:
        await said(client, *messages)
    return GONE if closed.value.rcvd is None else closed.value.rcvd.code


async def said(client: ClientConnection, *messages: str | bytes) -> None:
    for message in messages:
        await client.send(message)
    await drained(client)


async def said_as_text(client: ClientConnection, message: bytes) -> None:
    await client.send(message, text=True)
    await drained(client)


@pytest.mark.parametrize("part", ["socket", "view"])
def test_attack_a_giant_frame(studio: Studio, stage: Mapping[str, str], part: str) -> None:
    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage[part]) as client:
            assert await cut(client, bytes(limits.MOST_MESSAGE_BYTES + 1)) in {1009, GONE}

    asyncio.run(run())


def test_attack_a_frame_that_is_said_to_be_endless(
    studio: Studio, stage: Mapping[str, str]
) -> None:
    """Eight exabytes are announced, and nothing is set aside for them."""
    host, _, port = studio.base.removeprefix("http://").partition(":")
    key = base64.b64encode(os.urandom(16)).decode()
    head = (
        f"GET {stage['socket']} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: Upgrade\r\n"
        f"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
        f"Authorization: Bearer {studio.token}\r\n\r\n"
    )
    with socket.create_connection((host, int(port)), timeout=30.0) as wire:
        wire.sendall(head.encode())
        assert wire.recv(12) == b"HTTP/1.1 101"
        wire.sendall(b"\x81\xff" + struct.pack("!Q", 2**62) + b"\x00" * 4)
        rest = b""
        while part := wire.recv(65536):
            rest += part
    assert struct.pack("!H", 1009) in rest


@pytest.mark.parametrize(
    "message",
    [
        "",
        "null",
        "[]",
        "{",
        '{"type": "command"}',
        '{"type": "command", "name": "os.system"}',
        '{"type": ' + "[" * 5000 + "]" * 5000 + "}",
        '{"type": "keys", "held": ["KeyA"], "time_ms": NaN, "seq": 1}',
        '{"type": "keys", "held": ["KeyA"], "time_ms": 1e999, "seq": 1}',
        '{"type": "keys", "held": ' + json.dumps(["KeyA"] * 500) + ', "time_ms": 0}',
        '{"type": "keys", "held": [], "time_ms": 0, "pushed": {"theta": NaN}}',
        '{"type": "keys", "held": [], "time_ms": 0, "pushed": {"theta": 1.5}}',
        '{"type": "keys", "held": [], "time_ms": 0, "pushed": {"theta": "1"}}',
        '{"type": "keys", "held": [], "time_ms": 0, "pushed": {"' + "x" * 41 + '": 0.5}}',
        '{"type": "command", "name": "feel", "sensitivity": NaN}',
        '{"type": "command", "name": "feel", "sensitivity": 1e9}',
        '{"type": "command", "name": "series", "wanted": -1, "automatic": true}',
        '{"type": "command", "name": "signal", "signal": "x", "pointer": [NaN, 0, 1]}',
        '{"type": "command", "name": "play", "policy": "' + "../" * 60 + '"}',
        '{"type": "command", "name": "demonstrate", "options": {"density": 1e308}}',
        '{"type": "command", "name": "session", "session": ' + "9" * 300 + "}",
        '{"type": "' + "x" * 5000 + '"}',
        '{"type": "keys", "held": ["\\ud800"], "time_ms": 0, "seq": "a"}',
    ],
    ids=lambda message: message[:40],
)
def test_attack_messages_that_are_none(
    studio: Studio, stage: Mapping[str, str], message: str
) -> None:
    """The page is told that this was nothing, and goes on."""

    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage["socket"]) as client:
            await client.send(message)
            told: dict[str, Any] = {"type": "status"}
            while told["type"] == "status":
                told = json.loads(await client.recv())
            assert told["type"] == "notice"
            assert "Traceback" not in told["text"]
            assert len(told["text"]) < 2000
            await client.send('{"type": "keys", "held": [], "time_ms": 0.0, "seq": 7}')
            while told["type"] != "ack":
                told = json.loads(await client.recv())
            assert told["seq"] == 7

    asyncio.run(run())


def test_attack_a_message_beyond_what_a_page_says(studio: Studio, stage: Mapping[str, str]) -> None:
    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage["socket"]) as client:
            assert await cut(client, '{"type": "' + "x" * 200_000 + '"}') in {1009, GONE}

    asyncio.run(run())


def test_attack_bytes_where_text_is_meant(studio: Studio, stage: Mapping[str, str]) -> None:
    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage["socket"]) as client:
            assert await cut(client, b'{"type": "keys"}') in {1000, 1003, 1008}

    asyncio.run(run())


def test_attack_text_that_is_no_utf_8(studio: Studio, stage: Mapping[str, str]) -> None:
    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage["socket"]) as client:
            with pytest.raises(ConnectionClosed) as closed:
                await said_as_text(client, b"\xff\xfe")
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1007

    asyncio.run(run())


def test_attack_a_flood_of_messages(studio: Studio, stage: Mapping[str, str]) -> None:
    """A page that says thousands of things at once is hung up on; others are not."""
    keys = '{"type": "keys", "held": ["KeyA"], "time_ms": 0.0, "seq": 1}'

    async def run() -> None:
        async with (
            asyncio.timeout(30),
            joined(studio, stage["socket"]) as other,
            joined(studio, stage["socket"]) as client,
        ):
            assert await cut(client, *[keys] * 3000) in {1008, GONE}
            await other.send(keys)
            told: dict[str, Any] = {"type": ""}
            while told["type"] != "ack":
                told = json.loads(await other.recv())

    asyncio.run(run())


def test_attack_a_flood_of_pings(studio: Studio, stage: Mapping[str, str]) -> None:
    async def run() -> None:
        async with asyncio.timeout(30), joined(studio, stage["socket"]) as client:
            for _ in range(2000):
                await client.ping()
            await client.send('{"type": "keys", "held": [], "time_ms": 0.0, "seq": 9}')
            told: dict[str, Any] = {"type": ""}
            while told["type"] != "ack":
                told = json.loads(await client.recv())

    asyncio.run(run())


def test_attack_what_a_viewer_tells_the_view(studio: Studio, stage: Mapping[str, str]) -> None:
    """Of a viewer nothing is read, not even what would cut an author off; and both look on.

    What an author's messages can do is in tests/studio/test_heard.py.
    """
    with Store(studio.workspace.store_url) as store:
        viewer = Tokens(store).add("Looks on", Role.VIEWER, time.time())
    told = [*map(msgspec.msgpack.encode, (*OTHERS, CAMERA)), b"\xc1"]

    async def run() -> None:
        async with (
            asyncio.timeout(30),
            joined(studio, stage["view"], viewer) as looking,
            joined(studio, stage["view"]) as author,
        ):
            for message in told:
                await looking.send(message)
            await (await looking.ping())
            assert await cut(author, told[-1]) == 1008
            await (await looking.ping())

    asyncio.run(run())


def test_attack_as_many_sockets_as_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One token takes its share of websockets, and when it lets go there is room again."""
    monkeypatch.setattr(limits, "SOCKETS_EACH", 3)
    with within(tmp_path / "studio") as base:
        stage = httpx.post(
            f"{base}{API}/stages", json={"scene": "asteroids"}, headers=BEARER, trust_env=False
        ).json()
        url = base.replace("http", "ws") + stage["socket"]

        async def run() -> None:
            held = [await connect(url, additional_headers=BEARER, proxy=None) for _ in range(3)]
            with pytest.raises(InvalidStatus):
                await connect(url, additional_headers=BEARER, proxy=None)
            for one in held:
                await one.close()
            for _ in range(100):
                try:
                    again = await connect(url, additional_headers=BEARER, proxy=None)
                except InvalidStatus:
                    continue
                await again.close()
                return
            raise AssertionError("nobody gets in any more")

        asyncio.run(run())


def test_attack_as_many_stages_as_there_are(tmp_path: Path) -> None:
    with (
        within(tmp_path / "studio") as base,
        httpx.Client(base_url=base, headers=BEARER, trust_env=False, timeout=60) as client,
    ):
        codes = []
        for _ in range(61):
            answer = client.post(f"{API}/stages", json={"scene": "asteroids"})
            codes.append(answer.status_code)
        assert codes == [201] * 60 + [429]
        assert int(answer.headers["retry-after"]) >= 1
        assert "60 stages" in answer.json()["detail"]
        for stage in client.get(f"{API}/stages").json()["items"]:
            client.delete(f"{API}/stages/{stage['id']}")
        assert client.post(f"{API}/stages", json={"scene": "asteroids"}).status_code == 201
