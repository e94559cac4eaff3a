"""Downloads: with an ETag, so that who has the same already is told so (RFC 9110, 13.1)."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

BINARY: Mapping[str, Any] = {"schema": {"type": "string", "format": "binary"}}
TEXT: Mapping[str, Any] = {"schema": {"type": "string"}}

PIECE_BYTES = 2**18
"""A file is read in pieces of this size while it is sent."""


def etag_of(*parts: object) -> str:
    """The ETag of content that follows from `parts`."""
    return f'"{hashlib.sha256(repr(parts).encode()).hexdigest()[:32]}"'


def matches(header: str, etag: str) -> bool:
    """Whether an If-None-Match or If-Match header names `etag`."""
    named = [one.strip().removeprefix("W/") for one in header.split(",")]
    return etag in named or "*" in named


def download(
    request: Request, etag: str, name: str, media_type: str, content: Callable[[], bytes]
) -> Response:
    """The bytes of `content` as a file called `name`, or 304 where the client has them."""
    headers = _headers(etag, name)
    if matches(request.headers.get("if-none-match", ""), etag):
        return Response(status_code=304, headers=headers)
    return Response(content(), media_type=media_type, headers=headers)


def download_file(
    request: Request, etag: str, name: str, media_type: str, file: BinaryIO
) -> Response:
    """`download` of an open file, which is read while it is sent, and closed."""
    headers = _headers(etag, name)
    if matches(request.headers.get("if-none-match", ""), etag):
        file.close()
        return Response(status_code=304, headers=headers)
    headers["Content-Length"] = str(os.fstat(file.fileno()).st_size)
    return _FileResponse(file, media_type, headers)


class _FileResponse(StreamingResponse):
    def __init__(self, file: BinaryIO, media_type: str, headers: Mapping[str, str]) -> None:
        pieces = iter(lambda: file.read(PIECE_BYTES), b"")
        super().__init__(pieces, media_type=media_type, headers=headers)
        self._file = file

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        with self._file:  # also where whoever asked is gone before the first piece
            await super().__call__(scope, receive, send)


def _headers(etag: str, name: str) -> dict[str, str]:
    return {
        "ETag": etag,
        "Cache-Control": "private, no-cache",
        "Content-Disposition": f'attachment; filename="{name}"',
    }


def downloadable(contents: Mapping[str, Mapping[str, Any]]) -> dict[int | str, dict[str, Any]]:
    """What OpenAPI says of a download: `contents` by media type."""
    etag = {"ETag": {"description": "Of this content.", "schema": {"type": "string"}}}
    return {
        200: {"description": "The content.", "content": dict(contents), "headers": etag},
        304: {"description": "The client has it already: If-None-Match named its ETag."},
    }
