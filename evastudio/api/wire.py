"""HTTP on the wire: uvicorn's protocol with a limit on how long a client may take for a request."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from evastudio.api import limits


class PatientProtocol(H11Protocol):
    """One connection; closed where the next request is not whole in time (slowloris).

    That counts from the connection, and from the end of the answer before: also what is left of a
    body that was answered early must have come by then. A body that is awaited has its own limit.
    """

    _timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        self._wait_no_more()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.cycle is not None and not self.cycle.response_complete:
            self._wait_no_more()

    def on_response_complete(self) -> None:
        self._wait()
        super().on_response_complete()
        if not self.cycle.response_complete:  # the next one was here already
            self._wait_no_more()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        self._wait_no_more()
        super().handle_websocket_upgrade(event)

    def send_400_response(self, msg: str) -> None:
        """What is no HTTP is answered like everything else, as a problem."""
        told = {
            "type": "about:blank",
            "title": "Invalid request",
            "status": 400,
            "detail": f"This is no request over HTTP, or one of more than {limits.MOST_HEAD_BYTES} "
            "bytes of headers.",
        }
        headers: list[Any] = [("content-type", "application/problem+json"), ("connection", "close")]
        for part in (
            h11.Response(status_code=400, headers=headers),
            h11.Data(data=json.dumps(told).encode()),
            h11.EndOfMessage(),
        ):
            self.transport.write(self.conn.send(part) or b"")
        self.transport.close()

    def _wait(self) -> None:
        self._wait_no_more()
        self._timer = self.loop.call_later(limits.HEAD_S, self.transport.close)

    def _wait_no_more(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
