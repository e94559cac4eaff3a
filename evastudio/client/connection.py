"""The connection to a studio: requests, their errors, and what is asked again by itself."""

from __future__ import annotations

import io
import secrets
import time
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import numpy as np
from numpy.typing import NDArray

from evastudio.errors import (
    AccessError,
    ConflictError,
    InvalidInputError,
    NotFoundError,
    StorageError,
    StudioError,
    UnreachableError,
)

API = "/api/v1"
NPZ = "application/x-npz"
BINARY = "application/octet-stream"
TRIES = 3
"""How often what may be asked again is asked."""
PAUSE_S = 0.5
"""Before it is asked again, unless the studio says otherwise."""
LONGEST_PAUSE_S = 10.0

Arrays = Mapping[str, NDArray[Any]]

KINDS: Mapping[int, type[StudioError]] = {
    400: InvalidInputError,
    401: AccessError,
    403: AccessError,
    404: NotFoundError,
    409: ConflictError,
    412: ConflictError,
    413: InvalidInputError,
    415: InvalidInputError,
    421: AccessError,
    422: InvalidInputError,
    429: AccessError,
}


class Connection:
    """To one studio. Safe to use from several threads."""

    def __init__(self, url: str, token: str | None, timeout_s: float) -> None:
        """`url` may be the address that the studio printed, token included.

        Raises InvalidInputError for what is no address, or where there is no token.
        """
        parts = urlsplit(url)
        if parts.scheme not in {"http", "https"} or not parts.netloc:
            raise InvalidInputError(
                f"{url.partition('?')[0]!r} is no address of a studio; give one as it prints it, "
                "such as http://127.0.0.1:8400."
            )
        token = token or parse_qs(parts.query).get("token", [None])[0]
        if token is None:
            raise InvalidInputError(
                "No token was given. The studio prints it as part of its address when it starts."
            )
        self.base = f"{parts.scheme}://{parts.netloc}"
        self.headers = {"Authorization": f"Bearer {token}"}
        self._client = httpx.Client(
            base_url=self.base, headers=self.headers, timeout=timeout_s, trust_env=False
        )

    def close(self) -> None:
        self._client.close()

    def get(self, path: str, **query: Any) -> Any:
        """What the studio tells there, from JSON."""
        return self.send("GET", path, query).json()

    def post(self, path: str, body: Any = None, *, once: bool = False, **query: Any) -> Any:
        """What it answers to `body`, both JSON. It is asked again where an answer was lost, under
        a key by which the studio knows it, unless it is to be asked only `once`."""
        key = {} if once else {"Idempotency-Key": secrets.token_hex(16)}
        return self.send(
            "POST", path, query, headers=key, again=not once, json=body if body is not None else {}
        ).json()

    def put(self, path: str, body: Any) -> Any:
        """What it answers to `body`, both JSON."""
        return self.send("PUT", path, {}, json=body).json()

    def delete(self, path: str, **query: Any) -> Any:
        """What it answers, from JSON; None where it answers nothing."""
        answer = self.send("DELETE", path, query)
        return answer.json() if answer.content else None

    def pages(self, path: str, **query: Any) -> Iterator[Mapping[str, Any]]:
        """The items of a list, page after page."""
        cursor: Any = None
        while True:
            page = self.get(path, **query, cursor=cursor)
            yield from page["items"]
            cursor = page.get("next")
            if cursor is None:
                return

    def arrays(
        self,
        method: str,
        path: str,
        given: Arrays | None = None,
        *,
        again: bool = False,
        **query: Any,
    ) -> dict[str, NDArray[Any]]:
        """The arrays that it answers with, to those `given`, or to nothing."""
        content = None if given is None else packed(given)
        headers = {} if given is None else {"Content-Type": NPZ}
        answer = self.send(
            method, path, {**query, "format": "npz"}, headers=headers, again=again, content=content
        )
        with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
            return {name: found[name] for name in found.files}

    def send(
        self,
        method: str,
        path: str,
        query: Mapping[str, Any] | None = None,
        *,
        headers: Mapping[str, str] | None = None,
        again: bool = False,
        json: Any = None,
        content: bytes | None = None,
    ) -> httpx.Response:
        """One request; its answer, or the studio's refusal as an error.

        What changes nothing, or may be asked `again`, is, a few times, where no answer came or the
        studio is busy. Raises the errors of `evastudio.errors`, UnreachableError where none came.
        """
        tries = TRIES if again or method in {"GET", "PUT", "DELETE"} else 1
        asked = {name: value for name, value in (query or {}).items() if value is not None}
        for left in reversed(range(tries)):
            try:
                answer = self._client.request(
                    method, API + path, params=asked, headers=headers, json=json, content=content
                )
            except httpx.TransportError as error:
                if not left:
                    raise self.lost(error) from None
                time.sleep(PAUSE_S)
                continue
            if answer.status_code == 503 and left:
                time.sleep(pause_after(answer))
                continue
            if answer.is_error:
                raise refusal(answer)
            return answer
        raise AssertionError  # the last try returned or raised

    def stream(self, path: str, headers: Mapping[str, str], timeout_s: float) -> Any:
        """An answer that is read while it comes; for a `with` block."""
        return self._client.stream("GET", API + path, headers=headers, timeout=timeout_s)

    def lost(self, error: Exception) -> UnreachableError:
        """The error for an answer that did not come."""
        return UnreachableError(
            f"The studio at {self.base} does not answer ({error or type(error).__name__}). Is it "
            "running, and is that its address?"
        )


def packed(arrays: Arrays) -> bytes:
    """`arrays` as an npz file."""
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **arrays)
    return file.getvalue()


def refusal(answer: httpx.Response) -> StudioError:
    """The error that an answer tells, with the studio's sentence."""
    try:
        told = answer.json()
        title, detail = str(told["title"]), str(told["detail"])
    except (ValueError, KeyError, TypeError):
        title, detail = "", f"The studio answered with status {answer.status_code}."
    return refused(answer.status_code, title, detail)


def refused(status: int, title: str, detail: str) -> StudioError:
    """The error of a problem."""
    kind = StorageError if title == "Storage problem" else KINDS.get(status, StudioError)
    return kind(detail)


def pause_after(answer: httpx.Response) -> float:
    """How long a busy studio asks to wait."""
    told = answer.headers.get("retry-after", "")
    return min(float(told), LONGEST_PAUSE_S) if told.isdecimal() else PAUSE_S
