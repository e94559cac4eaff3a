"""Repeats: a write with an Idempotency-Key is done once, however often it is sent."""

from __future__ import annotations

import contextlib
import re
import time

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from evastudio.api.limits import MOST_UPLOAD_BYTES
from evastudio.api.problems import problem_response, standing_of
from evastudio.api.rights import writes
from evastudio.demonstrations.store import Store
from evastudio.errors import StudioError
from evastudio.live.answers import Answer, Answers, digest_of
from evastudio.live.tokens import Role

HEADER = "idempotency-key"
REPLAYED = "idempotency-replayed"
MOST_KEY = 200
KEY = re.compile(rf"[!-~]{{1,{MOST_KEY}}}")
MOST_ANSWER_BYTES = 1_000_000
"""Larger answers are not kept, and what gave them is done again."""


class Repeats:
    """ASGI middleware behind the guard. Only what was answered with success is kept.

    Of a viewer, who would fill the store with answers else, only of votes.
    """

    def __init__(self, app: ASGIApp, store: Store) -> None:
        self._app = app
        self._answers = Answers(store)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        given = Headers(scope=scope).get(HEADER) if scope["type"] == "http" else None
        if given is None or scope["method"] != "POST":
            await self._app(scope, receive, send)
            return
        if not KEY.fullmatch(given):
            detail = f"An Idempotency-Key has 1 to {MOST_KEY} plain characters and no blanks."
            await problem_response(422, "Invalid input", detail)(scope, receive, send)
            return
        person = scope.get("state", {}).get("person")
        if not writes(getattr(person, "role", Role.AUTHOR), scope["path"]):
            await self._app(scope, receive, send)
            return
        body = await _whole(receive)
        if body is None:
            detail = f"The body is larger than {MOST_UPLOAD_BYTES // 1_000_000} MB."
            await problem_response(413, "Too large", detail)(scope, receive, send)
            return
        key = digest_of(repr(getattr(person, "token", None)).encode(), given.encode())
        kind = Headers(scope=scope).get("content-type", "")
        digest = digest_of(
            scope["path"].encode(), scope.get("query_string", b""), kind.encode(), body
        )
        try:
            kept = await run_in_threadpool(self._answers.begin, key, digest, time.time())
        except StudioError as error:
            await problem_response(*standing_of(error), str(error))(scope, receive, send)
            return
        if kept is not None:
            replayed = Response(
                kept.body, kept.status, {REPLAYED: "true"}, media_type=kept.media_type or None
            )
            await replayed(scope, receive, send)
            return
        await self._once(key, scope, _again(body, receive), send)

    async def _once(self, key: str, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the application answer, and keep what it says before it is told."""
        held: list[Message] = []
        size = 0
        settled = False

        async def holding(message: Message) -> None:
            nonlocal size, settled
            held.append(message)
            size += len(message.get("body", b""))
            last = message["type"] == "http.response.body" and not message.get("more_body", False)
            if last:
                settled = await self._keep(key, held, size)
                if not settled:
                    settled = await self._forget(key)
            if last or size > MOST_ANSWER_BYTES:
                for one in held:
                    await send(one)
                held.clear()

        try:
            await self._app(scope, receive, holding)
        finally:
            if not settled:
                await self._forget(key)

    async def _keep(self, key: str, held: list[Message], size: int) -> bool:
        """Keep a whole answer that tells of success; whether it is kept."""
        if size > MOST_ANSWER_BYTES:
            return False
        start = held[0]
        if not 200 <= start["status"] < 300:
            return False
        kind = Headers(raw=list(start["headers"])).get("content-type", "")
        whole = b"".join(one.get("body", b"") for one in held[1:])
        with contextlib.suppress(StudioError):
            await run_in_threadpool(self._answers.keep, key, Answer(start["status"], kind, whole))
            return True
        return False

    async def _forget(self, key: str) -> bool:
        """Let the request be done again. Where the store refuses, it is found abandoned later."""
        with contextlib.suppress(StudioError):
            await run_in_threadpool(self._answers.forget, key)
        return True


async def _whole(receive: Receive) -> bytes | None:
    """The body, or None where it is too large."""
    data = bytearray()
    while True:
        message = await receive()
        data += message.get("body", b"")
        if len(data) > MOST_UPLOAD_BYTES:
            return None
        if not message.get("more_body", False):
            return bytes(data)


def _again(body: bytes, receive: Receive) -> Receive:
    """`receive` as if `body` had not been read yet."""
    left = [body]

    async def again() -> Message:
        if left:
            return {"type": "http.request", "body": left.pop(), "more_body": False}
        return await receive()

    return again
