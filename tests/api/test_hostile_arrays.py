"""Hostile arrays: bombs, lies and code. Each by its name."""

from __future__ import annotations

import io
import pickle
import struct
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from evastudio.api.arrays import MOST_BYTES, NPZ
from tests.api.refusals import refused

if TYPE_CHECKING:
    from conftest import Studio

pytestmark = pytest.mark.usefixtures("unharmed")
API = "/api/v1"
DECIDE = f"{API}/policies/asteroids-careful/decide"


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
