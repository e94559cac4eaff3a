"""Hostile files of policies and clips. Each by its name."""

from __future__ import annotations

import json
import pickle
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from safetensors.numpy import save

from evastudio.workspace import shipped
from tests.api.refusals import refused
from tests.motion.walker import bvh, walking

if TYPE_CHECKING:
    from conftest import Studio

pytestmark = pytest.mark.usefixtures("unharmed")
API = "/api/v1"
BINARY = {"Content-Type": "application/octet-stream"}
SHIPPED = (shipped() / "policies" / "asteroids-careful.safetensors").read_bytes()


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
