"""Access: who may talk to the server at all. One guard in front of every route and websocket."""

from __future__ import annotations

import hmac
import html
import ipaddress
import socket
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import cookie_parser
from starlette.responses import HTMLResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from evastudio.api.problems import problem_response

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
ANY_HOST = frozenset({"0.0.0.0", "::", "[::]"})
PAGE_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'self'; base-uri 'none'; "
    "form-action 'none'; object-src 'none'"
)
VIEW_POLICY = (
    "default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'self' 'unsafe-inline'; connect-src 'self' data: blob:; worker-src blob:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'; object-src 'none'"
)
"""viser's client is one page with its scripts inside, and one of them compiles more; it may talk
to this server alone."""


@dataclass(frozen=True)
class Door:
    """What the guard needs to know."""

    host: str
    """The address the server is bound to."""
    port: int
    token: str

    @property
    def cookie(self) -> str:
        """Cookies ignore ports, so the name tells them apart."""
        return f"evastudio-{self.port}"

    def admits_host(self, host_header: str) -> bool:
        """Whether a request addressed to that host is meant for this server (DNS rebinding)."""
        try:
            name = urlsplit(f"//{host_header}").hostname or ""
        except ValueError:  # half an IPv6 address
            return False
        if name in {"localhost", "127.0.0.1", "::1", self.host.strip("[]").lower()}:
            return True
        if self.host not in ANY_HOST:
            return False
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return name == socket.gethostname().lower()
        return True

    def knows(self, token: str) -> bool:
        """Whether that is the token, in constant time."""
        return hmac.compare_digest(token.encode(), self.token.encode())


class Guard:
    """ASGI middleware: Host, token and Origin are checked before anything else happens."""

    def __init__(self, app: ASGIApp, door: Door) -> None:
        self._app = app
        self._door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        websocket = scope["type"] == "websocket"
        refusal = self._refusal(scope, headers, websocket)
        if refusal is None:
            await self._app(scope, receive, send if websocket else _hardened(scope, send))
        elif websocket:
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": ""})
        else:
            await refusal(scope, receive, _hardened(scope, send))

    def _refusal(self, scope: Scope, headers: Headers, websocket: bool) -> Response | None:
        """The answer to a request that may not pass, or None."""
        host = headers.get("host", "")
        if not self._door.admits_host(host):
            return problem_response(
                421, "Wrong host", "This server does not answer to that host name."
            )
        bearer = headers.get("authorization", "")
        scheme, _, given = bearer.partition(" ")
        by_header = scheme.lower() == "bearer" and self._door.knows(given.strip())
        if not websocket and scope["path"] == "/":
            offered = dict(parse_qsl(scope.get("query_string", b"").decode("latin-1")))
            if self._door.knows(offered.get("token", "")):
                return self._welcome(offered)
        if not by_header and not self._door.knows(self._cookie(headers)):
            return problem_response(
                401,
                "No access",
                "Open the address that the studio printed when it started; it carries the access "
                "token. Programs send it as 'Authorization: Bearer TOKEN'.",
            )
        origin = headers.get("origin")
        needs_origin = websocket or scope["method"] not in SAFE_METHODS
        if origin is None:
            allowed = by_header or not needs_origin
        else:
            allowed = origin.partition("://")[2] == host
        if not allowed and (needs_origin or origin is not None):
            return problem_response(
                403, "Wrong origin", "This request came from another site and was refused."
            )
        return None

    def _cookie(self, headers: Headers) -> str:
        """Read as browsers write them: other servers of this host put anything into theirs."""
        return cookie_parser(headers.get("cookie", "")).get(self._door.cookie, "")

    def _welcome(self, query: dict[str, str]) -> Response:
        """Swap the token in the address for a cookie, so that it does not stay in the history."""
        rest = urlencode({name: value for name, value in query.items() if name != "token"})
        # Not a redirect: after a link from another site the browser would follow it without the
        # strict cookie. A page of our own that leads on is a new start.
        target = html.escape("/" + (f"?{rest}" if rest else ""))
        response = HTMLResponse(
            f'<!doctype html><title>EVA Studio</title><meta http-equiv="refresh" '
            f'content="0; url={target}"><a href="{target}">Enter</a>'
        )
        response.set_cookie(
            self._door.cookie, self._door.token, httponly=True, samesite="strict", path="/"
        )
        return response


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
