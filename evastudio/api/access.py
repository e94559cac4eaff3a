"""Access: who may talk to the server at all. One guard in front of every route and websocket."""

from __future__ import annotations

import asyncio
import contextlib
import html
import math
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import cookie_parser
from starlette.responses import HTMLResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from evastudio.api import limits
from evastudio.api.connections import Connections
from evastudio.api.door import Door
from evastudio.api.people import Credential, People, Person
from evastudio.api.problems import problem_response
from evastudio.api.refusal import FOR_PROGRAMS, told_to_people
from evastudio.api.rights import READING, REFUSAL, SOCKET, may
from evastudio.api.throttle import Throttle
from evastudio.errors import StudioError
from evastudio.live.tokens import cookie_of

SHUT = "frame-ancestors 'self'; base-uri 'none'; form-action 'none'; object-src 'none'"
PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    f"connect-src 'self'; frame-src 'self'; {SHUT}"
)
VIEW_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src 'self' data: blob:; font-src data:; "
    f"connect-src 'self' data: blob:; worker-src blob:; {SHUT}"
)
"""viser's client is one page that unpacks its scripts and styles from itself, and one of them makes
more from text. It may talk to this server alone."""


class Guard:
    """ASGI middleware: host, who it is, origin and rights are checked before anything else happens.

    Whoever is let in is found in the scope's state as `person`.
    """

    def __init__(self, app: ASGIApp, door: Door, people: People) -> None:
        self._app = app
        self._door = door
        self._people = people
        self._throttle = Throttle()
        self._connections = Connections(people.good)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        websocket = scope["type"] == "websocket"
        sending = send if websocket else _hardened(scope, told_to_people(scope, send))
        found = await self._admitted(scope, headers, websocket)
        if isinstance(found, Person):
            scope.setdefault("state", {})["person"] = found
            await self._answer(found, scope, receive, sending)
        elif websocket:
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": ""})
        else:
            await found(scope, receive, sending)

    async def _answer(self, person: Person, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the application answer, until it has, or until the token is revoked."""
        websocket = scope["type"] == "websocket"
        receiving = receive if websocket or scope["method"] in READING else _prompt(receive)
        with self._connections.answering(person, websocket) as connection:
            try:
                await self._app(scope, receiving, send)
            except asyncio.CancelledError:
                if not connection.cut:
                    raise
                connection.task.uncancel()
                with contextlib.suppress(Exception):  # it has ended by itself at this moment
                    await send(
                        {"type": "websocket.close", "code": 4401, "reason": "No longer let in."}
                        if websocket
                        else {"type": "http.response.body", "body": b"", "more_body": False}
                    )

    async def _admitted(self, scope: Scope, headers: Headers, websocket: bool) -> Person | Response:
        """Who may pass, or the answer to a request that may not."""
        host = headers.get("host", "")
        if not self._door.admits_host(host):
            return problem_response(
                421, "Wrong host", "This server does not answer to that host name."
            )
        query = scope.get("query_string", b"")
        if len(scope.get("raw_path") or b"") + len(query) > limits.MOST_TARGET_BYTES:
            return problem_response(414, "Address too long", "The address is too long.")
        if not websocket and scope["path"] == "/" and b"token=" in query:
            return await self._welcome(scope, headers, dict(parse_qsl(query.decode("latin-1"))))
        scheme, _, given = headers.get("authorization", "").partition(" ")
        cookie = self._cookie(headers, host)
        person: Person | Response | None = None
        by_header = scheme.lower() == "bearer"
        if by_header:
            person = await self._known(scope, Credential(given.strip(), cookie=False))
        elif cookie:
            person = await self._known(scope, Credential(cookie, cookie=True))
        if person is None:
            return problem_response(
                401,
                "No access",
                "Open the address that the studio printed when it started; it carries the access "
                f"token.{FOR_PROGRAMS}",
            )
        if not isinstance(person, Person):
            return person
        method = SOCKET if websocket else scope["method"]
        origin = headers.get("origin")
        if origin is None:
            allowed = by_header or method in READING
        else:
            allowed = origin == self._door.origin(host)
        if not allowed:
            return problem_response(
                403, "Wrong origin", "This request came from another site and was refused."
            )
        if not may(person.role, method, scope["path"]):
            return problem_response(403, "Not for viewers", REFUSAL)
        full = self._connections.full(person, websocket)
        if full is not None:
            status, told = full
            return _later(status, "Too much at once", told, limits.RETRY_S)
        return person

    async def _known(self, scope: Scope, shown: Credential) -> Person | Response | None:
        """Whose credential that is, None, or the answer where it cannot be looked at now."""
        now_s = asyncio.get_running_loop().time()
        address = (scope.get("client") or ("", 0))[0]
        wait_s = self._throttle.wait_s(address, shown.digest, now_s)
        if wait_s > 0.0:
            return _later(
                429,
                "Too many wrong tokens",
                f"Too many wrong tokens came from this address. Try again in {wait_s:.0f} s.",
                math.ceil(wait_s),
            )
        try:
            person = await self._people.who(shown)
        except StudioError as error:
            return _later(503, "Storage problem", str(error), limits.RETRY_S)
        if person is None:
            self._throttle.wrong(address, shown.digest, now_s)
        else:
            self._throttle.right(shown.digest)
        return person

    def _cookie(self, headers: Headers, host: str) -> str:
        """Read as browsers write them: other servers of this host put anything into theirs."""
        return cookie_parser(headers.get("cookie", "")).get(self._door.cookie(host), "")

    async def _welcome(self, scope: Scope, headers: Headers, query: dict[str, str]) -> Response:
        """Swap the token in the address for a cookie, so that it does not stay in the history."""
        if headers.get("sec-fetch-dest", "document") != "document":
            return problem_response(
                403, "Wrong origin", "Another page asked for this one; open it by itself."
            )
        given = query.pop("token", "")
        token = self._people.redeem(given, asyncio.get_running_loop().time()) or given
        person = await self._known(scope, Credential(token, cookie=False))
        if isinstance(person, Response):
            return person
        if person is None:
            return problem_response(
                401,
                "No access",
                "The token in this address is not, or no longer, good. Open the address that the "
                "studio printed when it started last, or ask for a new token.",
            )
        # Not a redirect: after a link from another site the browser would follow it without the
        # strict cookie. A page of our own that leads on is a new start.
        target = html.escape("/" + (f"?{urlencode(query)}" if query else ""))
        response = HTMLResponse(
            '<!doctype html><title>EVA Studio</title><link rel="icon" href="/web/icon.svg">'
            f'<meta http-equiv="refresh" content="0; url={target}"><a href="{target}">Enter</a>'
        )
        host = headers.get("host", "")
        response.set_cookie(
            self._door.cookie(host),
            cookie_of(token),
            path="/",
            httponly=True,
            samesite="strict",
            secure=self._door.secure(host),
        )
        return response


def _later(status: int, title: str, detail: str, seconds: int) -> Response:
    """A problem that time mends."""
    response = problem_response(status, title, detail)
    response.headers["Retry-After"] = str(seconds)
    return response


def _prompt(receive: Receive) -> Receive:
    """`receive`, for bodies that come at a fair pace. A slow one is answered with 408."""
    loop = asyncio.get_running_loop()
    start_s, came, whole = loop.time(), 0, False

    async def prompt() -> Message:
        nonlocal came, whole
        if whole:
            return await receive()
        allowed_s = start_s + limits.BODY_S + came / limits.SLOWEST_BYTES
        try:
            async with asyncio.timeout_at(allowed_s):
                message = await receive()
        except TimeoutError:
            raise HTTPException(
                408, "The body came too slowly; send it again.", {"Connection": "close"}
            ) from None
        came += len(message.get("body", b""))
        whole = not message.get("more_body", False)
        return message

    return prompt


def _hardened(scope: Scope, send: Send) -> Send:
    """`send` with the security headers added."""
    policy = VIEW_POLICY if scope["path"].startswith("/view/") else PAGE_POLICY

    async def hardened(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers["Content-Security-Policy"] = policy
            headers["X-Content-Type-Options"] = "nosniff"
            headers["Referrer-Policy"] = "no-referrer"
            headers["X-Frame-Options"] = "SAMEORIGIN"
            headers["Cross-Origin-Opener-Policy"] = "same-origin"
            headers["Cross-Origin-Resource-Policy"] = "same-origin"
            headers.setdefault("Cache-Control", "no-store")
        await send(message)

    return hardened
