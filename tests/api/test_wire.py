"""Attacks on the wire: requests that are none, or more than one. Each by its name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import httpx
import pytest

from tests.api.served import raw, status

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"


@pytest.mark.parametrize(
    "head",
    [
        "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        "Content-Length: 5\r\nContent-Length: 6\r\n",
        "Content-Length: -5\r\n",
        "Content-Length: 5, 6\r\n",
        "Content-Length: 0x5\r\n",
        "Transfer-Encoding: xchunked\r\n",
        "Transfer-Encoding: chunked, identity\r\n",
        "Transfer-Encoding : chunked\r\n",
        " Transfer-Encoding: chunked\r\n",
        "X: a\rTransfer-Encoding: chunked\r\n",
    ],
)
def test_attack_request_smuggling(studio: Studio, head: str) -> None:
    """What a proxy could take for one request is never answered as two."""
    known = (
        f"Host: {studio.base.removeprefix('http://')}\r\nAuthorization: Bearer {studio.token}\r\n"
        "Connection: close\r\n"
    )
    smuggled = f"0\r\n\r\nGET {API}/me HTTP/1.1\r\n{known}\r\n"
    sent = f"POST {API}/sessions HTTP/1.1\r\n{known}{head}\r\n{smuggled}"
    answer = raw(studio.base, sent.encode())
    assert status(answer) >= 400
    assert b"200 OK" not in answer


@pytest.mark.parametrize(
    "line",
    [
        "GET / HTTP/9.9",
        "GET /\x00 HTTP/1.1",
        "GET /\r\nX: y HTTP/1.1",
        "\x16\x03\x01\x02\x00\x01",
        "PRI * HTTP/2.0",
        "GET http://evil.example/ HTTP/1.1",
        "CONNECT evil.example:443 HTTP/1.1",
    ],
)
def test_attack_malformed_first_lines(studio: Studio, line: str) -> None:
    host = studio.base.removeprefix("http://")
    answer = raw(studio.base, f"{line}\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode())
    assert status(answer) in {400, 401, 404, 405}


def test_attack_header_injection(studio: Studio) -> None:
    """Names that hold line breaks add no header to the answers that repeat them."""
    for name in ("a%0d%0aSet-Cookie:%20x=y", "a%0aX-Evil:%201", "%E5%98%8D%E5%98%8ASet-Cookie:x"):
        for path in (f"/view/{name}/", f"{API}/policies/{name}", f"{API}/policies/{name}/file"):
            answer = studio.client.get(path)
            assert answer.status_code in {404, 422}
            assert "set-cookie" not in answer.headers
            assert "x-evil" not in answer.headers
    answer = httpx.get(studio.url + "&a%0d%0aX-Evil:%201=2", trust_env=False)
    assert "x-evil" not in answer.headers


def test_attack_no_body_of_an_answer_is_taken_for_another_kind(studio: Studio) -> None:
    for path in ("/", f"{API}/scenes", f"{API}/policies/<b>", "/web/js/main.js", "/nope"):
        assert studio.client.get(path).headers["x-content-type-options"] == "nosniff"
