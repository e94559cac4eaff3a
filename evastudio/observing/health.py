"""Health: whether the studio answers and its store does, for whoever sends it traffic."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send

PATH = "/health"
ANSWER_S = 2.0
"""A store that takes longer is not reachable."""
FRESH_S = 1.0
"""So long an answer of the store is good for everybody who asks."""

logger = logging.getLogger(__name__)


class Health:
    """ASGI middleware that answers GET /health before anybody asks for a token.

    200 and `{"status": "ok"}`, or 503 and `{"status": "not ok"}`; it tells nothing else. However
    many ask, the store is asked once a second at most, and by one thread.
    """

    def __init__(self, app: ASGIApp, ask: Callable[[], object]) -> None:
        """`ask` asks the store anything; it raises where that is not possible, and may hang."""
        self._app = app
        self._ask = ask
        self._asking: asyncio.Task[bool] | None = None
        self._asked_at = float("-inf")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["path"] != PATH:
            await self._app(scope, receive, send)
            return
        if scope["method"] not in ("GET", "HEAD"):
            response = JSONResponse({"status": "ok"}, 405, {"Allow": "GET, HEAD"})
        else:
            well = await self._well()
            response = JSONResponse({"status": "ok" if well else "not ok"}, 200 if well else 503)
        response.headers["Cache-Control"] = "no-store"
        await response(scope, receive, send)

    async def _well(self) -> bool:
        now = time.monotonic()
        if self._asking is None or (self._asking.done() and now - self._asked_at > FRESH_S):
            self._asking = asyncio.create_task(self._answers())
            self._asked_at = now
        try:
            return await asyncio.wait_for(asyncio.shield(self._asking), ANSWER_S)
        except TimeoutError:
            return False

    async def _answers(self) -> bool:
        try:
            await asyncio.to_thread(self._ask)
        except Exception as error:
            logger.warning("The store does not answer", exc_info=error)
            return False
        return True
