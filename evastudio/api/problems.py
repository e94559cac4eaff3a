"""Errors over HTTP: RFC 9457 problem+json with the sentence a person can read."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from evastudio.api.limits import RETRY_S
from evastudio.errors import (
    BusyError,
    ConflictError,
    InvalidInputError,
    NotFoundError,
    StorageError,
    StudioError,
)
from evastudio.logs import request_id

logger = logging.getLogger(__name__)

MEDIA_TYPE = "application/problem+json"
PROBLEM: Mapping[str, Any] = {
    "type": "object",
    "description": "RFC 9457. The detail is a sentence a person can read.",
    "properties": {
        "type": {"type": "string"},
        "title": {"type": "string"},
        "status": {"type": "integer", "minimum": 400, "maximum": 599},
        "detail": {"type": "string"},
        "request": {"type": "string", "description": "Its X-Request-ID, which the log tells too."},
    },
    "required": ["type", "title", "status", "detail"],
}
"""As JSON Schema."""

STATUS: tuple[tuple[type[StudioError], int, str], ...] = (
    (NotFoundError, 404, "Not found"),
    (BusyError, 429, "Too much at once"),
    (ConflictError, 409, "Not possible now"),
    (InvalidInputError, 422, "Invalid input"),
    (StorageError, 409, "Storage problem"),
)

TOO_LARGE = "Content Too Large"
"""What Starlette says of a body that is larger than it may be."""
SENTENCES: Mapping[int, str] = {
    400: "The request cannot be read.",
    404: "There is nothing at this address.",
    405: "This address takes {allowed}, not {method}.",
    413: "The body is larger than this address reads; send less at once.",
}


def standing_of(error: StudioError) -> tuple[int, str]:
    """The status and the title of an error."""
    for kind, status, title in STATUS:
        if isinstance(error, kind):
            return status, title
    return 400, "Not possible"


def problem(error: StudioError) -> dict[str, object]:
    """An error as a problem."""
    status, title = standing_of(error)
    return {"type": "about:blank", "title": title, "status": status, "detail": str(error)}


def problem_response(status: int, title: str, detail: str) -> Response:
    """One problem as the body of a response."""
    told = detail.encode("utf-8", "backslashreplace").decode()  # half a letter can be in a name
    body: dict[str, object] = {
        "type": "about:blank",
        "title": title,
        "status": status,
        "detail": told,
    }
    if (request := request_id.get()) is not None:
        body["request"] = request
    return JSONResponse(body, status_code=status, media_type=MEDIA_TYPE)


def install(app: FastAPI) -> None:
    """Answer every error of `app` as a problem."""

    @app.exception_handler(StudioError)
    async def studio_error(_: Request, error: StudioError) -> Response:
        status, title = standing_of(error)
        response = problem_response(status, title, str(error))
        if status == 429:
            response.headers["Retry-After"] = str(RETRY_S)
        return response

    @app.exception_handler(RequestValidationError)
    async def invalid(request: Request, error: RequestValidationError) -> Response:
        found = error.errors()
        if isinstance(error.body, bytes) and [tuple(one["loc"]) for one in found] == [("body",)]:
            given = request.headers.get("content-type", "nothing")[:80]
            detail = f"The body is said to be {given!r}; send application/json."
            return problem_response(415, "Wrong kind of body", detail)
        return problem_response(422, "Invalid input", "; ".join(_wrong(found, error.body)[:5]))

    @app.exception_handler(HTTPException)
    async def http_error(request: Request, error: HTTPException) -> Response:
        title = HTTPStatus(error.status_code).phrase
        detail = str(error.detail)
        if error.status_code == 400 and not error.headers:  # only bodies that are no JSON
            return problem_response(422, "Invalid input", "The body is no JSON in UTF-8.")
        headers = dict(error.headers or {})
        if error.status_code == 405:
            headers["Allow"] = _methods(request)
        if detail in (title, TOO_LARGE):
            detail = SENTENCES.get(error.status_code, detail + ".").format(
                method=request.method, allowed=headers.get("Allow", "other methods")
            )
        response = problem_response(error.status_code, title, detail)
        response.headers.update(headers)
        return response

    @app.exception_handler(Exception)
    async def unexpected(_: Request, error: Exception) -> Response:
        logger.error("A request failed", exc_info=error)
        return problem_response(
            500, "Failed", "This did not work, for a reason that the server's log tells."
        )


class Sizes:
    """ASGI middleware: a body that says beforehand that it is too large is refused as a problem.

    Starlette refuses it by itself, in plain text.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        refused = False

        async def sending(message: Message) -> None:
            nonlocal refused
            if message["type"] == "http.response.start" and message["status"] == 413:
                kind = Headers(raw=message["headers"]).get("content-type", "")
                refused = kind.startswith("text/plain")
                if refused:
                    response = problem_response(413, HTTPStatus(413).phrase, SENTENCES[413])
                    await response(scope, receive, send)
            if not refused:
                await send(message)

        await self._app(scope, receive, sending)


def _wrong(found: Sequence[Mapping[str, Any]], body: object) -> list[str]:
    """Where a request is wrong, and how; where any of several forms will do, by the nearest."""
    told: dict[object, dict[object, list[str]]] = {}
    for one in found:
        kind, *path = one["loc"]
        missing = path[-1] if path and one["type"] == "missing" else None
        value, where = body, list[str]()
        choice, form = None, None
        for part in path:
            if _holds(value, part):
                value = value[part]  # type: ignore[index]
            elif kind == "body" and part != missing:  # the name of a form, not of a place
                if form is None:
                    choice, form = tuple(where), part
                continue
            where.append(str(part))
        said = (
            f"{'.'.join(where)[:200] or 'body'}: {one['msg'].removeprefix('Value error, ')[:500]}"
        )
        told.setdefault(choice, {}).setdefault(form, []).append(said)
    nearest = [
        said
        for forms in told.values()
        for errors in forms.values()
        for said in errors
        if len(errors) == min(map(len, forms.values()))
    ]
    return list(dict.fromkeys(nearest))


def _holds(value: object, part: object) -> bool:
    if isinstance(value, list):
        return isinstance(part, int) and part < len(value)
    return isinstance(value, dict) and part in value


def _methods(request: Request) -> str:
    """What the address of `request` takes, by all of its routes: a router tells of the first."""
    paths, path = request.app.openapi()["paths"], request.url.path
    found: set[str] = set()
    for template in (path,) if path in paths else paths:  # a word goes before what stands for any
        pattern = re.sub(r"\\{\w+\\}", "[^/]+", re.escape(template))
        if re.fullmatch(pattern, path):
            found |= {method.upper() for method in paths[template]}
    return ", ".join(sorted(found)) or "GET"
