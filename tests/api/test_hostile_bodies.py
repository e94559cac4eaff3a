"""Hostile bodies: too large, too slow, and letters that are none. Each by its name."""

from __future__ import annotations

import gzip
import json
import pickle
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from evastudio.api import limits
from evastudio.api.arrays import NPZ
from tests.api.refusals import refused
from tests.api.served import BEARER, raw, status, within

if TYPE_CHECKING:
    from conftest import Studio

pytestmark = pytest.mark.usefixtures("unharmed")
API = "/api/v1"
SESSIONS = f"{API}/sessions"
DECIDE = f"{API}/policies/asteroids-careful/decide"
JSON = {"Content-Type": "application/json"}


# -- size and pace -----------------------------------------------------------------------------


def test_attack_a_body_that_is_said_to_be_endless(studio: Studio) -> None:
    """No route waits for what it will not take."""
    host = studio.base.removeprefix("http://")
    described = studio.client.get(f"{API}/openapi.json").json()["paths"]
    tried = 0
    for path, methods in described.items():
        for method, operation in methods.items():
            if "requestBody" not in operation:
                continue
            (kind, *_) = operation["requestBody"]["content"]
            target = path.replace("{", "").replace("}", "")
            for name in ("session", "take", "evaluation", "job"):
                target = target.replace(f"/{name}/", "/1/").removesuffix("/file/name")
            answer = raw(
                studio.base,
                f"{method.upper()} {target} HTTP/1.1\r\nHost: {host}\r\nContent-Type: {kind}\r\n"
                f"Authorization: Bearer {studio.token}\r\nConnection: close\r\n"
                f"Content-Length: {10**12}\r\n\r\n".encode(),
            )
            assert status(answer) in {404, 405, 413}, (method, path)
            if status(answer) == 413:
                assert b"application/problem+json" in answer, (method, path)
                tried += 1
    assert tried >= 12


def test_attack_a_body_that_never_says_its_size(studio: Studio) -> None:
    def endless() -> Iterator[bytes]:
        yield b'{"scene": "'
        for _ in range(80):
            yield b"a" * 65_536

    answer = studio.client.post(SESSIONS, content=endless(), headers=JSON)
    refused(answer, 413)


def test_attack_more_json_than_arrays_take(studio: Studio) -> None:
    body = b'{"states": [[' + b"0.0," * (limits.MOST_JSON_BYTES // 4) + b"0.0]]}"
    assert NPZ in refused(studio.client.post(DECIDE, content=body, headers=JSON), 413)


def test_attack_a_body_that_unpacks_by_itself(studio: Studio) -> None:
    """Nothing is unpacked because a header says that it is packed."""
    body = gzip.compress(b'{"scene": "asteroids", "name": "' + b"a" * 10_000_000)
    answer = studio.client.post(
        SESSIONS, content=body, headers={**JSON, "Content-Encoding": "gzip"}
    )
    refused(answer)


def test_attack_headers_without_end(studio: Studio) -> None:
    host = studio.base.removeprefix("http://")
    lines = "".join(f"X-{number}: {'a' * 500}\r\n" for number in range(100))
    answer = raw(studio.base, f"GET / HTTP/1.1\r\nHost: {host}\r\n{lines}".encode())
    assert status(answer) == 400
    assert b"application/problem+json" in answer


def test_attack_an_address_without_end(studio: Studio) -> None:
    answer = studio.client.get(f"{API}/scenes?" + "a" * limits.MOST_TARGET_BYTES)
    refused(answer, 414)


def test_attack_slow_heads_and_bodies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who sends a request drop by drop is hung up on, at whatever point of it."""
    monkeypatch.setattr(limits, "HEAD_S", 0.3)
    monkeypatch.setattr(limits, "BODY_S", 0.3)
    with within(tmp_path / "studio") as base:
        host = base.removeprefix("http://")
        known = f"Host: {host}\r\nAuthorization: {BEARER['Authorization']}\r\n"
        assert raw(base, b"") == b""
        assert raw(base, b"GET / HTT") == b""
        assert raw(base, f"GET / HTTP/1.1\r\n{known}X-Slow: ".encode()) == b""
        post = f"POST {SESSIONS} HTTP/1.1\r\n{known}Content-Type: application/json\r\n"
        answer = raw(base, f'{post}Content-Length: 50\r\n\r\n{{"scene"'.encode())
        assert status(answer) == 408
        assert b"application/problem+json" in answer
        # Answered before its body was read, which then does not come either.
        answer = raw(base, f"DELETE /nothing HTTP/1.1\r\n{known}Content-Length: 9\r\n\r\n".encode())
        assert status(answer) in {404, 405}
        # A second request on a connection that was good has no more time than the first.
        answer = raw(base, f"GET {API}/me HTTP/1.1\r\n{known}\r\nGET /".encode())
        assert answer.count(b"HTTP/1.1 ") == 1
        assert status(answer) == 200


def test_attack_as_many_requests_at_once_as_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One token does not take all there is to have; and whoever waits is told for how long."""
    monkeypatch.setattr(limits, "REQUESTS_EACH", 3)
    with within(tmp_path / "studio") as base:
        host, _, port = base.removeprefix("http://").partition(":")
        head = (
            f"POST {SESSIONS} HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Length: 9\r\n"
            f"Content-Type: application/json\r\nAuthorization: {BEARER['Authorization']}\r\n\r\n"
        )
        held = [socket.create_connection((host, int(port))) for _ in range(3)]
        for wire in held:
            wire.sendall(head.encode())
        for _ in range(200):
            answer = httpx.get(f"{base}{API}/me", headers=BEARER, trust_env=False)
            if answer.status_code == 429:
                break
        assert answer.status_code == 429
        assert int(answer.headers["retry-after"]) >= 1
        assert "3 requests" in answer.json()["detail"]
        for wire in held:
            wire.sendall(b'{"a": 1}\n')
            assert wire.recv(20).startswith(b"HTTP/1.1 422")
            wire.close()
        assert httpx.get(f"{base}{API}/me", headers=BEARER, trust_env=False).status_code == 200


# -- JSON --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b'{"scene": ' + b"[" * 50_000 + b"]" * 50_000 + b', "name": "x"}',
        b'{"scene": "asteroids", "name": "\xff\xfe"}',
        b'{"scene": "asteroids", "name": "\\ud800"}',
        b'{"scene": "asteroids", "name": "a\\u0000b"}',
        b'{"scene": "asteroids", "name": "\xed\xa0\x80"}',
        b'{"scene": "asteroids", "name": "\xc0\xaf"}',
        '{"scene": "asteroids", "name": "x"}'.encode("utf-16"),
        b'{"scene": 1e999, "name": NaN}',
        b'{"scene": ' + b"9" * 500_000 + b', "name": "x"}',
        b'{"scene": "asteroids", "name": "x", "__proto__": {"role": "author"}}',
        b'{"scene": "asteroids", "name": "' + b"a" * 900_000 + b'"}',
        b"\x1f\x8b" + bytes(100),
        pickle.dumps({"scene": "asteroids", "name": "x"}),
        b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]><a>&b;</a>",
    ],
    ids=lambda body: repr(body[:24]),
)
def test_attack_json_that_is_none_or_too_deep(studio: Studio, body: bytes) -> None:
    refused(studio.client.post(SESSIONS, content=body, headers=JSON))


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "9" * 400, "1e308"])
def test_attack_numbers_that_are_none(studio: Studio, number: str) -> None:
    """NaN, infinity and what no computer's number can hold: wherever a number is taken."""
    stage = studio.client.post(f"{API}/stages", json={"scene": "asteroids"}).json()
    bodies = {
        f"{API}/stages": '{"scene": "asteroids", "options": {"density": %s}}',
        f"{API}/stages/{stage['id']}/commands": (
            '{"name": "demonstrate", "options": {"density": %s}}'
        ),
        f"{API}/evaluations": '{"scene": "asteroids", "policies": ["straight"], "worlds": %s}',
        f"{API}/worlds": '{"scene": "asteroids", "seeds": [%s]}',
        DECIDE: '{"states": [[%s, 1, 1, 1, 1, 1, 1]]}',
    }
    for path, body in bodies.items():
        refused(studio.client.post(path, content=(body % number).encode(), headers=JSON), 400, 422)
    studio.client.delete(f"{API}/stages/{stage['id']}")


def test_attack_seeds_beyond_all_numbers(studio: Studio) -> None:
    for seed in (-1, 2**53, 2**64, 10**300, 1.5, None, [1]):
        body = json.dumps({"scene": "asteroids", "seed": seed})
        answer = studio.client.post(f"{API}/stages", content=body.encode(), headers=JSON)
        if seed is None:
            assert answer.status_code == 201
            studio.client.delete(f"{API}/stages/{answer.json()['id']}")
        else:
            refused(answer, 422)
