"""Problems as a page, for whoever opened an address in a browser."""

from __future__ import annotations

import base64
import hashlib
import html
import json

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import Message, Scope, Send

from evastudio.api.problems import MEDIA_TYPE

STYLE = """
:root { color-scheme: light dark; font: 17px/1.5 Inter, "Segoe UI", system-ui, sans-serif;
  background: light-dark(#e9edf5, #080b14); color: light-dark(#141a2b, #e9edf7); }
body { display: grid; place-content: center; min-height: 90vh; margin: 0; padding: 5vw; }
main { max-width: 34rem; }
h1 { margin: 0 0 .4em; font-size: 1.7rem; line-height: 1.2; }
p { margin: 0 0 1em; color: light-dark(#465169, #a3afc9); overflow-wrap: anywhere; }
a { color: light-dark(#0b66ac, #6fcbff); }
"""
"""The colours of `web/css/base.css`, which nobody gets who is not let in."""
_DIGEST = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
POLICY = (
    f"default-src 'none'; style-src 'sha256-{_DIGEST}'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
FOR_PROGRAMS = " Programs send it as 'Authorization: Bearer TOKEN'."
"""What a person need not read."""
NO_ACCESS = 401


def told_to_people(scope: Scope, send: Send) -> Send:
    """`send`, with problems as pages where a browser asked for one."""
    asked = Headers(scope=scope)
    if scope["method"] != "GET" or "text/html" not in asked.get("accept", ""):
        return send
    held: Message | None = None
    body = b""

    async def telling(message: Message) -> None:
        nonlocal held, body
        if message["type"] == "http.response.start":
            headers = Headers(raw=message["headers"])
            if headers.get("content-type") == MEDIA_TYPE:
                held = message
                return
        elif held is not None:
            body += message.get("body", b"")
            if message.get("more_body", False):
                return
            page = _page(json.loads(body))
            changed = MutableHeaders(raw=held["headers"])
            changed["Content-Type"] = "text/html; charset=utf-8"
            changed["Content-Length"] = str(len(page))
            changed["Content-Security-Policy"] = POLICY
            await send(held)
            held = None
            message = {"type": "http.response.body", "body": page}
        await send(message)

    return telling


def _page(problem: dict[str, object]) -> bytes:
    """What a person reads; only who is let in is led on."""
    told = str(problem["detail"]).removesuffix(FOR_PROGRAMS)
    title, detail = html.escape(str(problem["title"])), html.escape(told)
    onward = "" if problem["status"] == NO_ACCESS else '<p><a href="/">To the studio</a></p>'
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title} · EVA Studio</title><style>{STYLE}</style></head>"
        f"<body><main><h1>{title}</h1><p>{detail}</p>{onward}</main></body></html>"
    ).encode()
