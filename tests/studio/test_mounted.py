"""viser without a port: the private names it rests on, and that nothing listens."""

from __future__ import annotations

import asyncio
import inspect
import socket
from pathlib import Path
from typing import Any

import pytest
import viser
from viser import _messages, infra
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer

from evastudio.studio.mounted import SUBPROTOCOL, MountedViser, mounted_viser


def parameters(function: Any) -> list[str]:
    return list(inspect.signature(function).parameters)


def test_viser_is_the_version_that_the_mounting_was_written_for() -> None:
    assert viser.__version__ == "1.1.1", (
        "viser has changed: read evastudio/studio/mounted.py beside its infra/_infra.py, adapt the "
        "one to the other, then the checks below and this version."
    )


def test_private_parts_of_viser_are_what_the_mounting_takes_them_for() -> None:
    assert parameters(_infra._message_producer) == [
        "websocket",
        "buffer",
        "client_id",
        "backlog_done_message",
    ]
    assert parameters(_infra._message_consumer) == ["websocket", "handle_message", "message_class"]
    assert parameters(_infra._ClientHandleState) == ["message_buffer", "event_loop"]
    assert parameters(infra.WebsockClientConnection) == ["client_id", "client_state"]
    assert parameters(AsyncMessageBuffer)[:2] == ["event_loop", "persistent_messages"]
    assert "generator_cursors" in parameters(AsyncMessageBuffer)
    for message, fields in {
        _messages.SetCameraPositionMessage: ["position", "initial"],
        _messages.SetCameraLookAtMessage: ["look_at", "initial"],
        _messages.SetCameraUpDirectionMessage: ["position", "initial"],
        _messages.SetPositionMessage: ["name", "position"],
        _messages.SetOrientationMessage: ["name", "wxyz"],
    }.items():
        assert parameters(message) == fields
    plain = infra.WebsockServer("127.0.0.1", 0)
    for name in (
        "_client_connect_cb",
        "_client_disconnect_cb",
        "_client_state_from_id",
        "_live_connections",
        "_backlog_done_message",
        "_message_class",
        "_incoming_handlers",
        "_background_event_loop",
        "_server_thread",
    ):
        assert hasattr(plain, name), name
    source = inspect.getsource(viser.ViserServer.__init__)
    assert "infra.WebsockServer(" in source


def test_the_handler_follows_the_original_that_it_stands_in_for() -> None:
    """What a connection goes through in viser; the mounting repeats it."""
    source = inspect.getsource(infra.WebsockServer._background_worker)
    for line in (
        "_ClientHandleState(",
        "for cb in self._client_connect_cb:",
        "_message_producer(",
        "_message_consumer(connection, handle_incoming, message_class)",
        "self._broadcast_buffer.generator_cursors.pop(client_id, None)",
        "for cb in self._client_disconnect_cb:",
    ):
        assert line in source, line


def test_no_port_is_opened_and_the_public_tunnel_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    async def check() -> None:
        def refuse(*_: object) -> None:
            raise AssertionError("a port was opened")

        monkeypatch.setattr(socket.socket, "bind", refuse)
        server = mounted_viser(asyncio.get_running_loop(), "a stage")
        handlers = server._websock_server._incoming_handlers
        assert _messages.ShareUrlRequest not in handlers
        assert _messages.ShareUrlDisconnect not in handlers
        assert server.clients == 0
        server.close()
        server.close()

    asyncio.run(check())


def test_mounting_leaves_viser_itself_as_it_was() -> None:
    original = infra.WebsockServer

    async def check() -> None:
        server = mounted_viser(asyncio.get_running_loop())
        assert infra.WebsockServer is original
        assert isinstance(server, MountedViser)
        server.close()

    asyncio.run(check())


def test_mounting_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    async def check() -> None:
        mounted_viser(asyncio.get_running_loop()).close()

    asyncio.run(check())
    assert capfd.readouterr() == ("", "")


def test_closing_after_the_loop_has_ended_is_quiet() -> None:
    async def build() -> MountedViser:
        return mounted_viser(asyncio.get_running_loop())

    asyncio.run(build()).close()


def test_viser_client_asks_for_the_subprotocol_that_is_checked() -> None:
    client = Path(viser.__file__).parent / "client" / "build" / "index.html"
    assert client.is_file()
    assert f"viser-v{viser.__version__}" == SUBPROTOCOL
