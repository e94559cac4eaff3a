"""Every request under an id: counted by its route, written as one event, and told its id."""

from __future__ import annotations

import logging
import re
import secrets
import time

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from evastudio.logs import FACTS, request_id
from evastudio.observing.metrics import Metrics

HEADER = "X-Request-ID"
SANE = re.compile(r"[A-Za-z0-9._-]{8,64}")
"""What a caller may choose as an id; in place of anything else one is made."""
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
NO_ROUTE = "none"
"""Where a request was refused before it came to a route, or there is none."""
OTHER = "other"

logger = logging.getLogger(__name__)


class Requests:
    """ASGI middleware around everything else, the guard too."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        given = Headers(scope=scope).get(HEADER, "")
        number = given if SANE.fullmatch(given) else secrets.token_hex(8)
        request_id.set(number)  # each request has a task, and so a context, of its own
        answer = _Answer(scope, send, number, self._metrics)
        try:
            await self._app(scope, receive, answer.send)
        except Exception:
            answer.status = 500
            raise
        finally:
            answer.ended()


class _Answer:
    """What is sent back, looked at on its way."""

    def __init__(self, scope: Scope, send: Send, number: str, metrics: Metrics) -> None:
        self._scope = scope
        self._send = send
        self._number = number
        self._metrics = metrics
        self._began = time.perf_counter()
        self._socket: str | None = None
        self.status = 499
        """Of HTTP, or why a websocket closed; 499 where whoever asked was gone before."""

    @property
    def _route(self) -> str:
        """Of routers in routers FastAPI tells the whole path in a place of its own."""
        scope = self._scope
        whole = scope.get("fastapi", {}).get("effective_route_context")
        found = getattr(whole, "path", None) or getattr(scope.get("route"), "path", None)
        if found is None and "app_root_path" in scope:  # files, mounted under their folder
            found = f"{scope['root_path']}/{{path}}"
        return found or NO_ROUTE

    async def send(self, message: Message) -> None:
        kind = message["type"]
        if kind == "http.response.start":
            self.status = message["status"]
            MutableHeaders(scope=message)[HEADER] = self._number
        elif kind == "websocket.accept":
            self._socket = self._route
            self._metrics.sockets.labels(self._socket).inc()
        elif kind == "websocket.close":
            self.status = message.get("code", 1000)
        await self._send(message)

    def ended(self) -> None:
        seconds = time.perf_counter() - self._began
        if self._socket is not None:
            self._metrics.sockets.labels(self._socket).dec()
        method = self._scope.get("method", "WEBSOCKET")
        method = method if method in METHODS or method == "WEBSOCKET" else OTHER
        self._metrics.requests.labels(method, self._route, self.status).inc()
        if method != "WEBSOCKET":
            self._metrics.request_seconds.labels(self._route).observe(seconds)
        facts = {"method": method, "route": self._route, "status": self.status}
        logger.info("request", extra={FACTS: {**facts, "seconds": round(seconds, 6)}})
