"""What a view takes in of viser's own messages, sent raw: an author's camera, and nothing else."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

import msgspec
import pytest
from viser import _messages, infra
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from evastudio.studio import mounted
from evastudio.studio.view import View
from tests.studio.drawn import Slide, at, drained, joined, named, replay, served, window

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 2.0, 3.0],
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 300,
    "image_width": 400,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
RAY = {"ray_origin": [0.0] * 3, "ray_direction": [1.0, 0.0, 0.0], "modifier": None}
OTHERS: tuple[dict[str, Any], ...] = (
    {"type": "ShareUrlRequest"},
    {"type": "ShareUrlDisconnect"},
    {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": "<script>"}},
    {"type": "GuiButtonHoldMessage", "uuid": "x", "frequency": 1e9},
    {"type": "GuiFormSubmitMessage", "uuid": "x"},
    {"type": "GuiFormDirtyMessage", "uuid": "x"},
    {"type": "CommandTriggerMessage", "uuid": "x"},
    {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "x",
        "transfer_uuid": "y",
        "filename": "../../evil.py",
        "mime_type": "text/plain",
        "part_count": 1,
        "size_bytes": 10,
    },
    {
        "type": "FileTransferPart",
        "source_component_uuid": "x",
        "transfer_uuid": "y",
        "part_index": 0,
        "content": b"import os\n",
    },
    {"type": "GetRenderResponseMessage", "payload": b"x", "render_uuid": "y"},
    {
        "type": "TransformControlsUpdateMessage",
        "name": "/bodies/sled",
        "wxyz": [1.0, 0.0, 0.0, 0.0],
        "position": [9.0] * 3,
        "owner": "",
    },
    {
        "type": "SceneNodeClickMessage",
        "name": "/bodies/sled",
        "instance_index": None,
        "screen_pos": [0.5, 0.5],
        "owner": "",
        **RAY,
    },
    {"type": "ScenePointerMessage", "event_type": "click", "screen_pos": [[0.5, 0.5]], **RAY},
    {"type": "SetCameraPositionMessage", "position": [9.0] * 3, "initial": False},
    {"type": "SetPositionMessage", "name": "/bodies/sled", "position": [9.0] * 3},
    {"type": "RemoveSceneNodeMessage", "name": "/bodies/sled", "owner": ""},
)
"""What viser's client can send beside its camera, and some that only its server sends."""


def heard_of(
    messages: Sequence[dict[str, Any]], heard: bool, until: int
) -> list[type[infra.Message]]:
    """The kinds that reach viser's handlers when a client sends `messages`, then leaves.

    Returns once `until` came, and the client is gone.
    """
    kinds: list[type[infra.Message]] = []

    async def run() -> None:
        view = View(Slide(), asyncio.get_running_loop())
        enough = asyncio.Event()

        def note(_: infra.ClientId, message: infra.Message) -> None:
            kinds.append(type(message))
            if len(kinds) >= until:
                enough.set()

        for kind in infra.Message.get_subclasses():
            view._server._sockets.register_handler(kind, note)
        async with asyncio.timeout(30), served(view, heard) as address:
            view.show(at(0.0), fresh=True)
            async with joined(address) as client, joined(address) as other:
                await replay(client)
                await replay(other)
                for message in messages:
                    await client.send(msgspec.msgpack.encode(message))
                if until:
                    await enough.wait()
                await client.close()
                view.show(at(1.0))
                seen = await window(other)
                assert named(seen, "SetPositionMessage", "/bodies/sled")["position"][0] == 1.0
                assert {m["type"] for m in seen} <= {
                    "SetPositionMessage",
                    "SetOrientationMessage",
                    "SetCameraPositionMessage",
                    "SetCameraLookAtMessage",
                }

    asyncio.run(run())
    return kinds


def test_every_message_tried_is_one_that_viser_would_read() -> None:
    for message in (CAMERA, *OTHERS):
        infra.Message.deserialize(msgspec.msgpack.encode(message))


def test_of_an_author_only_the_camera_is_heard() -> None:
    assert heard_of([*OTHERS, CAMERA], heard=True, until=1) == [_messages.ViewerCameraMessage]


def test_of_a_viewer_nothing_is_heard() -> None:
    assert heard_of([*OTHERS, CAMERA], heard=False, until=0) == []


@pytest.mark.parametrize(
    "change",
    [
        {"position": [float("nan")] * 3},
        {"position": [1.0, 2.0]},
        {"wxyz": ["a", "b", "c", "d"]},
        {"fov": float("inf")},
        {"look_at": [[1.0], [2.0], [3.0]]},
        {"image_height": None},
        {"far": "x" * 100},
    ],
)
def test_a_camera_in_what_are_no_numbers_is_not_heard(change: dict[str, Any]) -> None:
    async def run() -> None:
        view = View(Slide(), asyncio.get_running_loop())
        async with asyncio.timeout(30), served(view) as address:
            view.show(at(0.0), fresh=True)
            async with joined(address) as client, joined(address) as other:
                await replay(client)
                await replay(other)
                await client.send(msgspec.msgpack.encode({**CAMERA, **change}))
                await client.close()
                view.show(at(1.0))
                await window(other)
                assert view.cameras == []

    asyncio.run(run())


@pytest.mark.parametrize(
    "raw",
    [
        b"",
        b"\xc1",
        b"\x91" * 4000,  # lists in lists in lists
        msgspec.msgpack.encode({"type": "NoSuchMessage"}),
        msgspec.msgpack.encode({"type": "_DeprecatedMessage"}),
        msgspec.msgpack.encode({"type": ["ViewerCameraMessage"]}),
        msgspec.msgpack.encode({**CAMERA, "more": 1}),
        msgspec.msgpack.encode({**CAMERA, "far": "x" * 10_000}),
        b"\xdd\xff\xff\xff\xff",  # a list of four thousand millions
    ],
)
def test_who_sends_what_viser_never_would_is_sent_away(raw: bytes) -> None:
    async def run() -> None:
        view = View(Slide(), asyncio.get_running_loop())
        async with asyncio.timeout(30), served(view) as address, joined(address) as client:
            await client.send(raw)
            with pytest.raises(ConnectionClosed) as closed:
                await drained(client)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1008

    asyncio.run(run())


async def flood(client: ClientConnection) -> None:
    raw = msgspec.msgpack.encode(CAMERA)
    for _ in range(int(3 * mounted.AT_ONCE)):
        await client.send(raw)
    await drained(client)


@pytest.mark.parametrize("heard", [True, False])
def test_a_flood_of_messages_ends_the_connection(heard: bool) -> None:
    async def run() -> None:
        view = View(Slide(), asyncio.get_running_loop())
        async with asyncio.timeout(30), served(view, heard) as address, joined(address) as client:
            with pytest.raises(ConnectionClosed) as closed:
                await flood(client)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1008

    asyncio.run(run())


def test_a_turn_by_hand_is_told_and_the_echo_of_what_was_sent_is_not() -> None:
    turns: list[tuple[list[float], list[float]]] = []

    async def inside() -> None:
        view = View(
            Slide(),
            asyncio.get_running_loop(),
            on_turn=lambda before, now: turns.append(
                (before.position.tolist(), now.position.tolist())
            ),
        )
        view.show(at(0.0), fresh=True)
        async with asyncio.timeout(30), served(view) as address, joined(address) as client:
            await replay(client)
            echo = {"position": [-8.0, 0.0, 0.0], "look_at": [0.0, 0.0, 0.0]}
            turned = {"position": [-8.0, 5.0, 1.0], "look_at": [0.0, 0.0, 0.0]}
            for told in ({}, echo, turned, turned):  # it begins where viser begins
                await client.send(msgspec.msgpack.encode({**CAMERA, **told}))
            while not turns:
                await asyncio.sleep(0)

    asyncio.run(inside())
    assert turns == [([-8.0, 0.0, 0.0], [-8.0, 5.0, 1.0])]
