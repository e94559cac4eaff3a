"""Hostile bodies: too large, too slow, bombs, lies and letters that are none. Each by its name."""

from __future__ import annotations

import gzip
import io
import json
import pickle
import socket
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
import pytest
from safetensors.numpy import save

from evastudio.api import limits
from evastudio.api.arrays import MOST_BYTES, NPZ
from evastudio.workspace import shipped
from tests.api.served import BEARER, raw, status, within
from tests.motion.walker import bvh, walking

if TYPE_CHECKING:
    from conftest import Studio

API = "/api/v1"
SESSIONS = f"{API}/sessions"
DECIDE = f"{API}/policies/asteroids-careful/decide"
BINARY = {"Content-Type": "application/octet-stream"}
JSON = {"Content-Type": "application/json"}
SHIPPED = (shipped() / "policies" / "asteroids-careful.safetensors").read_bytes()
REFUSED = {400, 408, 411, 413, 415, 422}
GROWTH_KB = 400_000
"""What reading something hostile may add to the most memory that the server ever had."""


def peak_kb(studio: Studio) -> int:
    """The most memory that the studio's process has had."""
    told = Path(f"/proc/{studio.process.pid}/status")
    if not told.exists():
        return 0
    (line,) = [one for one in told.read_text().splitlines() if one.startswith("VmHWM")]
    return int(line.split()[1])


@pytest.fixture(autouse=True)
def unharmed(studio: Studio) -> Iterator[None]:
    """After every attack the studio answers, and has not swollen."""
    before = peak_kb(studio)
    yield
    assert studio.client.get(f"{API}/me").status_code == 200
    assert peak_kb(studio) - before < GROWTH_KB


def refused(answer: httpx.Response, *statuses: int) -> str:
    """The sentence of a refusal, which is a problem."""
    assert answer.status_code in (statuses or REFUSED), answer.text[:200]
    assert answer.headers["content-type"] == "application/problem+json"
    detail: str = answer.json()["detail"]
    assert "Traceback" not in detail
    return detail


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


# -- arrays ------------------------------------------------------------------------------------


def zipped(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return buffer.getvalue()


def array(header: str, data: bytes = b"") -> bytes:
    """A .npy file with a header of one's own."""
    text = (header + "\n").encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + data


def described(shape: str, descr: str = "<f8") -> str:
    return f"{{'descr': {descr!r}, 'fortran_order': False, 'shape': {shape}, }}"


class Evil:
    """Writes a file where it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.write_text, (self.path, "executed"))


def bomb() -> bytes:
    """An npz of a few hundred kB that unpacks to more than is read."""
    return zipped({"states.npy": array(described(f"({MOST_BYTES // 8 + 1},)"), bytes(MOST_BYTES))})


def lying_bomb() -> bytes:
    """The same, but the archive says that it is small."""
    data = bytearray(bomb())
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        (member,) = archive.infolist()
    true = struct.pack("<I", member.file_size)
    while (at := data.find(true)) >= 0:
        data[at : at + 4] = struct.pack("<I", 1000)
    return bytes(data)


ARRAYS = pytest.mark.parametrize(
    "body",
    [
        b"",
        b"PK\x03\x04",
        bomb(),
        lying_bomb(),
        zipped({f"{number}.npy": array(described("(1,)"), bytes(8)) for number in range(5000)}),
        zipped({"states.npy": array(described("(1000000000000000, 1000)"))}),
        zipped({"states.npy": array(described("(-1, 7)"), bytes(56))}),
        zipped({"states.npy": array(described("(0, 99999999999999999999999)"))}),
        zipped({"states.npy": array(described("(" + "1," * 5000 + ")"), bytes(8))}),
        zipped({"states.npy": array(described("(1, 7)", "|O"), bytes(56))}),
        zipped({"states.npy": array(described("(1, 7)", "<U9999999"), bytes(56))}),
        zipped({"states.npy": array("__import__('os').system('true')")}),
        zipped({"states.npy": array("(" * 5000)}),
        zipped({"states.npy": b"\x93NUMPY\x03\x00\xff\xff\xff\xff{"}),
        zipped({"../../../tmp/evil.npy": array(described("(1, 7)"), bytes(56))}),
        zipped({"states.npy": array(described("(1, 7)"), np.full(7, np.nan).tobytes())}),
    ],
    ids=[
        *("nothing", "a stub", "a zip bomb", "a zip bomb that lies", "thousands of arrays"),
        *("a shape beyond memory", "a shape below zero", "a shape of nothing times everything"),
        *("thousands of axes", "objects", "huge letters", "code for a header", "nested headers"),
        *("a header of 4 GB", "a name that leads out", "NaN"),
    ],
)


@ARRAYS
def test_attack_arrays(studio: Studio, body: bytes) -> None:
    assert len(body) < 4_000_000
    refused(studio.client.post(DECIDE, content=body, headers={"Content-Type": NPZ}), 413, 422)


@ARRAYS
def test_attack_snapshots_and_steps_of_worlds(studio: Studio, body: bytes) -> None:
    """What is no snapshot, and no actions, leaves worlds as they were."""
    opened = studio.client.post(f"{API}/worlds", json={"scene": "asteroids", "seeds": [1]}).json()
    url = f"{API}/worlds/{opened['id']}"
    before = studio.client.get(f"{url}/state").content
    for answer in (
        studio.client.put(f"{url}/snapshot", content=body, headers={"Content-Type": NPZ}),
        studio.client.post(f"{url}/step", content=body, headers={"Content-Type": NPZ}),
    ):
        refused(answer, 413, 422)
    assert studio.client.get(f"{url}/state").content == before
    studio.client.delete(url)


def test_attack_arrays_that_would_run_code(studio: Studio, tmp_path: Path) -> None:
    buffer = io.BytesIO()
    evil = np.empty(1, dtype=object)
    evil[0] = Evil(tmp_path / "executed")
    np.savez(buffer, states=evil, allow_pickle=True)
    for body in (
        buffer.getvalue(),
        pickle.dumps(Evil(tmp_path / "executed")),
        zipped({"states.npy": pickle.dumps(Evil(tmp_path / "executed"))}),
    ):
        refused(studio.client.post(DECIDE, content=body, headers={"Content-Type": NPZ}), 422)
    assert not (tmp_path / "executed").exists()


# -- policies ----------------------------------------------------------------------------------


def headed(header: object, data: bytes = b"") -> bytes:
    """A safetensors file with a header of one's own."""
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


def metadata() -> dict[str, Any]:
    size = struct.unpack("<Q", SHIPPED[:8])[0]
    told: dict[str, Any] = json.loads(SHIPPED[8 : 8 + size])["__metadata__"]
    return told


def tensor(shape: list[int], start: int, end: int, dtype: str = "F64") -> dict[str, Any]:
    return {"dtype": dtype, "shape": shape, "data_offsets": [start, end]}


@pytest.mark.parametrize(
    "body",
    [
        b"",
        SHIPPED[:7],
        SHIPPED[:-1],
        SHIPPED + b"x",
        struct.pack("<Q", 2**63) + b"{}",
        struct.pack("<Q", 2**64 - 1),
        headed(b"[" * 1_000_000),
        headed(b'{"a":' * 200_000),
        headed({"__metadata__": metadata(), "a": tensor([2**40, 2**40], 0, 8)}, bytes(8)),
        headed({"__metadata__": metadata(), "a": tensor([1], 0, 2**60)}, bytes(8)),
        headed({"__metadata__": metadata(), "a": tensor([1], -8, 0)}, bytes(8)),
        headed(
            {"__metadata__": metadata(), "a": tensor([1], 0, 8), "b": tensor([1], 0, 8)}, bytes(8)
        ),
        headed({"__metadata__": metadata(), "a": tensor([-1], 0, 8)}, bytes(8)),
        headed({"__metadata__": metadata(), "a": tensor([1], 0, 8, "PICKLE")}, bytes(8)),
        headed({"__metadata__": {"evastudio": "[" * 100_000}}),
        headed({"__metadata__": {"evastudio": '{"format": 1e999}'}}),
        headed({"__metadata__": {**metadata(), "evastudio": '{"format": 999999999999}'}}),
        save({"a": np.zeros(3)}, {"evastudio": "{}"}),
        pickle.dumps({"a": 1}),
        b"PK\x03\x04" + bytes(100),
    ],
    ids=[
        *("nothing", "half a length", "cut short", "too long", "a header of 8 EB", "of 16 EB"),
        *("nested lists", "nested objects", "a shape beyond memory", "an end beyond the file"),
        *("a start before it", "two in one place", "a size below zero", "an unknown kind"),
        *("nested metadata", "an infinite format", "a format of the future", "no policy"),
        *("a pickle", "a zip"),
    ],
)
def test_attack_policies(studio: Studio, body: bytes) -> None:
    answer = studio.client.put(f"{API}/policies/hostile/file", content=body, headers=BINARY)
    refused(answer, 409, 413, 422)
    assert studio.client.get(f"{API}/policies/hostile").status_code == 404
    assert not list(studio.workspace.policies.glob("hostile*"))


# -- clips -------------------------------------------------------------------------------------

CLIP = bvh(walking(1.2, 0.2))


@pytest.mark.parametrize(
    ("name", "body"),
    [
        ("a.bvh", b""),
        ("a.bvh", CLIP.replace("Frames: ", "Frames: 9999999").encode()),
        ("a.bvh", CLIP.replace("OFFSET", "OFFSET nan", 1).encode()),
        ("a.bvh", b"HIERARCHY\nROOT a {" + b"JOINT a {" * 100_000 + b"\nMOTION\n"),
        ("a.bvh", b"HIERARCHY\n" + b"\n" * 5_000_000),
        ("a.bvh", b"HIERARCHY\n" + b" " * 5_000_000 + b"MOTION"),
        ("a.glb", b"glTF" + struct.pack("<IIII", 2, 2**32 - 1, 2**32 - 1, 0x4E4F534A)),
        ("a.glb", b"glTF" + struct.pack("<IIII", 2, 20 + 100_000, 100_000, 0x4E4F534A)
         + b"[" * 100_000),
        ("a.json", b"[" * 1_000_000),
        ("a.json", b'{"Frames": ' + b"9" * 100_000 + b"}"),
        ("a.py", b"import os"),
        ("a.bvh.py", b"import os"),
        ("clips.json", b"{}"),
        (".bvh", CLIP.encode()),
    ],
)  # fmt: skip
def test_attack_clips(studio: Studio, name: str, body: bytes) -> None:
    before = contents(studio.workspace.motion)
    refused(studio.client.put(f"{API}/clips/files/{name}", content=body), 422)
    assert contents(studio.workspace.motion) == before


def contents(folder: Path) -> dict[str, bytes]:
    """What is in a folder, by name; nothing where there is none."""
    return {path.name: path.read_bytes() for path in folder.glob("*")}
