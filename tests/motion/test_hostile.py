"""Broken and adversarial files: a clear error, and never more memory than a file is worth."""

from __future__ import annotations

import copy
import json
import random
import struct
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError, NotFoundError, StudioError
from evastudio.motion.bvh import read_bvh
from evastudio.motion.clip import Clip, fitting
from evastudio.motion.glb import Glb
from evastudio.motion.mocap import JOINTS, WIDTH, read_mocap
from evastudio.motion.retarget import retargeted
from evastudio.motion.skeleton import Skeleton, in_tree_order
from evastudio.motion.steps import gait_of
from tests.motion.walker import bvh, described, glb, packed, walking

WALK = walking(1.2, 0.6)
TEXT = bvh(WALK)
FILE = glb(WALK)
TOLD, DATA = described(WALK)
MEGABYTE = 1_000_000


def refused(read: Callable[[], Any], match: str, megabytes: float = 12.0) -> None:
    """`read` says what is wrong and allocates little on the way."""
    tracemalloc.start()
    try:
        with pytest.raises(InvalidInputError, match=match):
            read()
        assert tracemalloc.get_traced_memory()[1] < megabytes * MEGABYTE
    finally:
        tracemalloc.stop()


# -- BVH ---------------------------------------------------------------------------------------

ROOT = "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
MOTION = "}\nMOTION\nFrames: 2\nFrame Time: 0.1\n1 2 3\n4 5 6\n"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "no BVH file"),
        ("HIERARCHY\nROOT Hips {", "no BVH file"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: 1000000000"), "1000000000 moments"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: " + "9" * 18), "moments"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: 300000"), "cut off or damaged"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: 3"), "cut off|instead of 9"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: -2"), "must say"),
        (ROOT + MOTION.replace("0.1", "nan"), "'nan' where a number"),
        (ROOT + MOTION.replace("0.1", "1e-300"), "frame time"),
        (ROOT + MOTION.replace("5", "nan"), "NaN"),
        ((ROOT + MOTION.replace("5", "1e300")).replace("Xrotation", "Xposition"), "beyond"),
        (ROOT.replace("OFFSET 0 0 0", "OFFSET 0 1e300 0") + MOTION, "beyond"),
        (ROOT + MOTION.replace("5", "five"), "not made of numbers"),
        (ROOT + "}" + MOTION, "where its one ROOT"),
        (ROOT.replace("OFFSET 0 0 0", "OFFSET 0 inf 0") + MOTION, "'inf'"),
        (ROOT.replace("3 Z", "999999999999 Z") + MOTION, "channels"),
        (ROOT.replace("Zrotation", "Wrotation") + MOTION, "'Wrotation'"),
        (ROOT.replace("Zrotation", "Xrotation") + MOTION, "each once"),
        (ROOT + "JOINT a { " * 5000 + "}" * 5000 + MOTION, "deep"),
        (ROOT + "JOINT a { }" * 2000 + MOTION, "more than 1024 joints"),
        (ROOT + "JOINT " + "a " * 50 + MOTION, "opening brace"),
        (ROOT + "End Site { }" + MOTION, "end site"),
        (ROOT + "MOTION\nFrames: 2\nFrame Time: 0.1\n1 2 3\n4 5 6\n", "ends in the middle"),
    ],
)
def test_a_broken_bvh_is_refused(text: str, match: str) -> None:
    refused(lambda: read_bvh(text.encode(), "bad.bvh"), match)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("HIERARCHY\n" + "\n" * 3_000_000, "no BVH file"),
        ("HIERARCHY\n" + " \n\t" * 1_000_000 + "MOTION", "letters"),
        (ROOT + "OFFSET 0 0 0\n" * 300_000 + MOTION, "letters"),
        (ROOT + MOTION + "1 " * 3_000_000, "holds more instead of 6"),
        (ROOT + MOTION.replace("Frames: 2", "Frames: 3") + " " * 3_000_000, "holds 6 instead of 9"),
        (ROOT + MOTION.replace("6", "6" * 1_000_000), "infinite"),
    ],
    ids=["lines", "blanks", "offsets", "numbers", "blanks at the end", "digits"],
)
def test_a_bvh_without_end_takes_no_time_and_little_memory(text: str, match: str) -> None:
    """Quadratic, the first alone would take the better part of a day."""
    refused(lambda: read_bvh(text.encode(), "bad.bvh"), match, megabytes=40.0)


def test_a_bvh_of_many_bytes_is_refused_before_it_is_read() -> None:
    data = bytes(64_000_001)
    refused(lambda: read_bvh(data, "large.bvh"), "64000001 bytes")


# -- glTF --------------------------------------------------------------------------------------


def changed(*path: Any, to: Any) -> bytes:
    """The good file with one entry of its description changed."""
    told = copy.deepcopy(TOLD)
    place = told
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = to
    return packed(told, DATA)


def opened(data: bytes) -> Clip:
    return Glb(data, "bad.glb").clip("walk")


@pytest.mark.parametrize(
    ("path", "value", "match"),
    [
        (("accessors", 0, "count"), 10**9, "1000000000"),
        (("accessors", 0, "count"), -1, "-1"),
        (("accessors", 0, "count"), True, "True"),
        (("accessors", 0, "count"), 0, "without rows"),
        (("accessors", 0, "count"), 7.5, "7.5"),
        (("accessors", 1, "byteOffset"), 10**12, "byte"),
        (("accessors", 0, "componentType"), 9999, "number format"),
        (("accessors", 0, "type"), "MAT4", "MAT4"),
        (("accessors", 0, "sparse"), {"count": 10**9}, "one piece"),
        (("accessors", 0, "bufferView"), 10**6, "buffer view"),
        (("bufferViews", 0, "byteLength"), 10**10, "byte"),
        (("bufferViews", 0, "byteOffset"), -8, "byte"),
        (("bufferViews", 0, "byteStride"), 0, "row"),
        (("bufferViews", 0, "byteStride"), 1, "row"),
        (("buffers", 0, "uri"), "file:///etc/passwd", "outside of itself"),
        (("buffers", 0, "uri"), "https://example.org/x.bin", "outside of itself"),
        (("nodes", 3, "children"), [0], "circle"),
        (("nodes", 3, "children"), [3], "on itself"),
        (("nodes", 3, "children"), [4], "two others"),
        (("nodes", 3, "children"), [10**9], "node"),
        (("nodes", 3, "children"), "abc", "no list"),
        (("nodes", 0, "translation"), [1, 2], "3 finite numbers"),
        (("nodes", 0, "rotation"), "no", "4 finite numbers"),
        (("nodes", 0, "matrix"), [0] * 16, "flattens"),
        (("nodes", 0, "scale"), [1e300] * 3, "finite numbers"),
        (("nodes", 0, "scale"), [0] * 3, "scales its nodes"),
        (("nodes", 0, "translation"), [1e200, 0, 0], "finite numbers"),
        (("nodes",), [{}] * 5000, "5000 nodes"),
        (("nodes",), {}, "no list"),
        (("skins", 0, "joints"), [99], "node"),
        (("animations", 0, "samplers"), [], "sampler"),
        (("animations", 0, "channels"), [], "moves no joint"),
        (("animations", 0, "channels", 0, "target"), 5, "target"),
        (("animations", 0, "samplers", 1, "output"), 0, "type"),
    ],
)
def test_a_glb_that_lies_is_refused(path: tuple[Any, ...], value: Any, match: str) -> None:
    refused(lambda: opened(changed(*path, to=value)), match)


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (b"", "no .glb file"),
        (b"glTF" + bytes(100), "glTF 0"),
        (FILE[:-4], "bytes, but has"),
        (FILE[:12] + struct.pack("<I", 2**31) + FILE[16:], "claims a description"),
        (packed(b"[" * 100_000, b""), "damaged description"),
        (packed(b"\xff\xfe{}", b""), "damaged description"),
        (packed([], b""), "no description"),
        (packed({"nodes": []}, b""), "0 nodes"),
    ],
)
def test_a_broken_container_is_refused(data: bytes, match: str) -> None:
    refused(lambda: opened(data), match)


def keyed(values: np.ndarray, at: int) -> bytes:
    begin = TOLD["bufferViews"][at]["byteOffset"]
    raw = values.astype("<f4").tobytes()
    return packed(TOLD, DATA[:begin] + raw + DATA[begin + len(raw) :])


@pytest.mark.parametrize(
    ("values", "at", "match"),
    [
        (np.array([np.nan]), 1, "NaN or infinite"),
        (np.array([0.0, -1.0]), 0, "do not rise"),
        (np.array([-1.0]), 0, "do not rise"),
        (np.arange(37) * 1e7, 0, "up to an hour"),
        (np.arange(37) * 99.0, 0, "may have"),
    ],
)
def test_key_frames_that_cannot_be_played_are_refused(
    values: np.ndarray, at: int, match: str
) -> None:
    if match == "may have":  # an hour is 108,000 moments: too many for these joints
        fitting("short", 50_000, 15)
    refused(lambda: opened(keyed(values, at)), match)


def test_key_frames_that_every_joint_shares_are_not_read_for_each() -> None:
    """A few MB of key frames, named by a hundred joints, would be GBs."""
    rows, joints = 200_000, 100
    times = (np.arange(rows) * 1e-3).astype("<f4")
    data = times.tobytes() + np.tile(np.float32([0, 0, 0, 1]), (rows, 1)).tobytes()
    told = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 4 * rows},
            {"buffer": 0, "byteOffset": 4 * rows, "byteLength": 16 * rows},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": rows, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": rows, "type": "VEC4"},
        ],
        "nodes": [{"name": f"joint {number}"} for number in range(joints)],
        "animations": [
            {
                "name": "walk",
                "samplers": [{"input": 0, "output": 1}],
                "channels": [
                    {"sampler": 0, "target": {"node": number, "path": "rotation"}}
                    for number in range(joints)
                ],
            }
        ],
    }
    refused(lambda: opened(packed(told, data)), "more than 16000000 numbers", megabytes=200.0)
    twice = [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}] * 1000
    told["animations"][0]["channels"] = twice  # type: ignore[index]
    refused(lambda: opened(packed(told, data)), "twice", megabytes=80.0)


def test_a_clip_has_a_name_that_can_be_told() -> None:
    (name,) = Glb(changed("animations", 0, "name", to="half a letter: \ud800"), "w").clip_names
    assert name == "half a letter: ?"


def test_an_unknown_clip_is_told_with_those_there_are() -> None:
    with pytest.raises(NotFoundError, match=r"Did you mean 'walk'\?"):
        Glb(FILE, "good.glb").clip("wolk")


# -- captured clips ----------------------------------------------------------------------------


def captured(**changes: Any) -> bytes:
    frame = [0.1, 0, 0.85, 0] + [1.0, 0, 0, 0] * 3
    for _, _, _, width in JOINTS[3:]:
        frame += {4: [1.0, 0, 0, 0], 1: [0.0], 0: []}[width]
    return json.dumps({"Frames": [frame] * 5, **changes}).encode()


def test_a_captured_clip_is_read() -> None:
    clip = read_mocap(captured(), "still")
    assert clip.rate_hz == pytest.approx(10.0)
    assert clip.rotations.shape == (5, len(JOINTS), 4)
    height = retargeted(clip).root[:, 2]
    assert np.ptp(height) < 1e-9
    assert 0.85 < height[0] < 0.95


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (b"", "no captured clip"),
        (b"[" * 100_000, "no captured clip"),
        (b"[]", "no captured clip"),
        (captured(Frames=7), "no captured clip"),
        (captured(Frames=[]), "0 moments"),
        (captured(Frames=[[0.1] * 43] * 3), "44"),
        (captured(Frames=[[0.1] * 44, [0.1] * 43]), "not a table"),
        (captured(Frames=[[float("nan")] * 44] * 3), "NaN"),
        (captured(Frames=[[0.0] * 44] * 3), "lasts 0 s"),
        (captured(Frames=[[1e9] * 44] * 3), "lasts 2e"),
    ],
)
def test_a_broken_captured_clip_is_refused(data: bytes, match: str) -> None:
    assert WIDTH == 44
    refused(lambda: read_mocap(data, "bad.json"), match)


# -- anything ----------------------------------------------------------------------------------


ENTRIES = (
    *("nodes", "children", "skins", "joints", "animations", "channels", "samplers", "target"),
    *("node", "path", "input", "output", "accessors", "bufferViews", "count", "matrix", "name"),
)


def used(read: Callable[[], Clip]) -> None:
    """Reading, laying over the body and finding steps end well, or with an error for people."""
    try:
        clip = read()
        gait_of(retargeted(clip), clip.rate_hz, clip.name)
    except StudioError:
        return


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_damaged_bytes_never_escape_as_another_error(seed: int) -> None:
    rng = random.Random(seed)
    for good, read in (
        (TEXT.encode(), lambda data: read_bvh(data, "x")),
        (FILE, opened),
        (captured(), lambda data: read_mocap(data, "x")),
    ):
        data = bytearray(good)
        for _ in range(rng.randint(1, 8)):
            at = rng.randrange(len(data))
            kind = rng.random()
            if kind < 0.5:
                data[at] = rng.randrange(256)
            elif kind < 0.75:
                del data[at : at + rng.randint(1, 60)]
            else:
                data[at:at] = rng.choice([b"9" * 9, b"{", b"}", b"nan ", b"-", b"e308", b"[[["])
        used(lambda data=bytes(data), read=read: read(data))  # type: ignore[misc]


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(ENTRIES),
                inner,
                max_size=4,
            )
        ),
        max_leaves=12,
    ),
    st.sampled_from(["nodes", "skins", "animations", "accessors", "bufferViews", "buffers"]),
)
@settings(max_examples=80, deadline=None)
def test_any_description_is_read_or_refused(value: Any, where: str) -> None:
    told = {**TOLD, where: value}
    used(lambda: opened(packed(told, DATA)))


@given(st.lists(st.integers(-2, 12), max_size=12))
def test_circles_of_joints_are_found(parents: list[int]) -> None:
    try:
        order = in_tree_order(parents)
    except InvalidInputError:
        return
    place = {int(joint): index for index, joint in enumerate(order)}
    assert sorted(place) == list(range(len(parents)))
    assert all(parent < 0 or place[parent] < place[joint] for joint, parent in enumerate(parents))


def test_a_skeleton_and_a_clip_check_themselves() -> None:
    with pytest.raises(InvalidInputError, match="does not come before it"):
        Skeleton(("a", "b"), (1, 0), np.zeros((2, 3)))
    with pytest.raises(InvalidInputError, match="finite"):
        Skeleton(("a",), (-1,), np.full((1, 3), np.nan))
    one = Skeleton(("a",), (-1,), np.zeros((1, 3)))
    with pytest.raises(InvalidInputError, match="length zero"):
        Clip("c", one, 30.0, np.zeros((2, 1, 3)), np.zeros((2, 1, 4)))
    with pytest.raises(InvalidInputError, match="at least two"):
        Clip("c", one, 30.0, np.zeros((1, 1, 3)), np.ones((1, 1, 4)))
    with pytest.raises(InvalidInputError, match="expected"):
        Clip("c", one, 30.0, np.zeros((2, 2, 3)), np.ones((2, 1, 4)))
