"""Text that no store or page can hold is refused at the edge: NUL, and halves of letters."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from fastapi import Request
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection

from evastudio.api.arrays import JSON, NPZ
from evastudio.api.bodies import media_type
from evastudio.api.limits import MOST_JSON_BYTES
from evastudio.errors import InvalidInputError

_SUSPECT = re.compile(rb"\\u(?:0000|[dD][89a-fA-F])")
_BAD = re.compile("[\x00\ud800-\udfff]")


async def plain_text(connection: HTTPConnection) -> None:
    """Refuse a request whose path, query or JSON holds such text. Raises InvalidInputError."""
    for text in (*map(str, connection.path_params.values()), *_flat(connection.query_params)):
        _check(text)
    if isinstance(connection, Request) and media_type(connection) == JSON:
        data = await connection.body()
        if len(data) > MOST_JSON_BYTES:
            most = MOST_JSON_BYTES // 1_000_000
            raise HTTPException(413, f"JSON may have {most} MB; send {NPZ}, or less at once.")
        if not _is_plain(data):
            raise InvalidInputError("The body is no JSON in UTF-8; send it so.")
        if _SUSPECT.search(data):
            try:
                told = json.loads(data)
            except (ValueError, RecursionError):
                return  # who reads the body says so
            for text in _texts(told):
                _check(text)


def _is_plain(data: bytes) -> bool:
    """Whether that is UTF-8 without NUL, so that no reader takes it for another encoding."""
    try:
        return "\x00" not in data.decode("utf-8")
    except UnicodeDecodeError:
        return False


def _flat(query: Any) -> Iterator[str]:
    for pair in query.multi_items():
        yield from pair


def _texts(value: Any) -> Iterator[str]:
    """Every text in what was JSON, names of fields too; not by recursion, it may be deep."""
    left = [value]
    while left:
        one = left.pop()
        if isinstance(one, str):
            yield one
        elif isinstance(one, dict):
            left += one.keys()
            left += one.values()
        elif isinstance(one, list):
            left += one


def _check(text: str) -> None:
    if _BAD.search(text):
        raise InvalidInputError(
            f"The text {text[:80]!a} holds a character that cannot be kept (NUL, or half of "
            "a letter); leave it out."
        )
