"""Reading binary glTF: the skeleton and the animations of a .glb file (Khronos glTF 2.0).

Only what lies in the file itself is read: no address, and no other file, is ever opened.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evastudio.errors import InvalidInputError, not_found
from evastudio.motion.clip import Clip, fitting
from evastudio.motion.rotations import from_axes, normalized, slerp
from evastudio.motion.skeleton import LARGEST, MOST_JOINTS, Skeleton, in_tree_order
from evastudio.world.spaces import Array

MOST_BYTES = 64_000_000
MOST_JSON = 16_000_000
MOST_KEYED = 16_000_000
"""Numbers of all key frames of a clip; several joints may share them, so the file's size says
little."""
RATE_HZ = 30.0
"""Clips are sampled so often, whatever their key frames."""
LONGEST_S = 3600.0
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
PATHS = {"translation": 3, "rotation": 4}


class Glb:
    """A .glb file, checked; its clips are read one by one when they are asked for.

    Raises InvalidInputError where the file is broken, not closed in itself, or too large.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self._name = name
        if len(data) > MOST_BYTES:
            raise self._error(f"has {len(data)} bytes; a .glb file may have {MOST_BYTES}")
        text, self._bytes = self._chunks(data)
        try:
            told = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self._error(f"holds a damaged description ({type(error).__name__})") from None
        if not isinstance(told, dict):
            raise self._error("holds no description of a scene")
        self._told: Mapping[str, Any] = told
        for number, buffer in enumerate(self._list("buffers")):
            if number > 0 or "uri" in self._entry(buffer, "a buffer"):
                raise self._error(
                    "refers to data outside of itself; export it as one .glb with all data inside"
                )
        self._order, self.skeleton = self._nodes()
        self._place = {int(node): joint for joint, node in enumerate(self._order)}
        self._animations: dict[str, Mapping[str, Any]] = {}
        for number, animation in enumerate(self._list("animations")):
            entry = self._entry(animation, "an animation")
            self._animations.setdefault(_legible(entry.get("name", number)), entry)

    @property
    def clip_names(self) -> tuple[str, ...]:
        """Names of its animations, in the order of the file."""
        return tuple(self._animations)

    def clip(self, name: str) -> Clip:
        """The animation of that name, at `RATE_HZ`. Raises NotFoundError, InvalidInputError."""
        if name not in self._animations:
            raise not_found("clip", name, self._animations, f"in {self._name!r}")
        animation = self._animations[name]
        samplers = self._items(animation, "samplers")
        tracks: dict[tuple[int, str], tuple[Array, Array, str]] = {}
        keyed = 0
        for one in self._items(animation, "channels"):
            channel = self._entry(one, "a channel")
            target = self._entry(channel.get("target"), "a channel's target")
            path, node = target.get("path"), target.get("node")
            if path not in PATHS or node is None:
                continue
            sampler = self._entry(self._pick(samplers, channel.get("sampler"), "sampler"), "it")
            joint = self._place[self._index(node, len(self._place), "node")]
            if (joint, path) in tracks:
                raise self._error(f"moves node {node} twice in its clip {name!r}")
            times, values = self._track(sampler, PATHS[path])
            keyed += times.size + values.size
            if keyed > MOST_KEYED:
                raise self._error(f"has more than {MOST_KEYED} numbers in its clip {name!r}")
            tracks[joint, path] = times, values, str(sampler.get("interpolation"))
        if not tracks:
            raise self._error(f"moves no joint in its clip {name!r}")
        length_s = max(float(times[-1]) for times, _, _ in tracks.values())
        if not length_s <= LONGEST_S:
            raise self._error(f"has a clip {name!r} of {length_s:g} s; expected up to an hour")
        frames = max(2, math.ceil(length_s * RATE_HZ - 1e-3) + 1)
        fitting(name, frames, len(self.skeleton.names))
        moments = np.minimum(np.arange(frames) / RATE_HZ, length_s)
        translations = np.tile(self.skeleton.offsets, (frames, 1, 1))
        rotations = np.tile(self.skeleton.rests, (frames, 1, 1))
        for (joint, path), (times, values, interpolation) in tracks.items():
            if path == "translation":
                translations[:, joint] = sampled(times, values, moments, interpolation)
                translations[:, joint] *= self._scales[joint]
            else:
                rotations[:, joint] = sampled(times, normalized(values), moments, interpolation)
        return Clip(name, self.skeleton, RATE_HZ, translations, rotations)

    # -- the container -------------------------------------------------------------------------

    def _chunks(self, data: bytes) -> tuple[bytes, bytes]:
        """The JSON and the binary chunk."""
        if len(data) < 20 or data[:4] != b"glTF":
            raise self._error("is no .glb file; a .gltf with files beside it must be packed first")
        _, version, length, size, kind = struct.unpack("<4sIIII", data[:20])
        if version != 2 or length != len(data) or kind != 0x4E4F534A:
            raise self._error(
                f"says it is glTF {version} with {length} bytes, but has {len(data)}; expected "
                "a whole file of version 2"
            )
        if size > min(MOST_JSON, len(data) - 20):
            raise self._error(f"claims a description of {size} bytes, more than it can hold")
        rest = data[20 + size :]
        if len(rest) < 8:
            return data[20 : 20 + size], b""
        held, kind = struct.unpack("<II", rest[:8])
        if held > len(rest) - 8 or kind != 0x004E4942:
            raise self._error(f"claims {held} bytes of data, but only {len(rest) - 8} follow")
        return data[20 : 20 + size], rest[8 : 8 + held]

    # -- nodes ---------------------------------------------------------------------------------

    def _nodes(self) -> tuple[list[int], Skeleton]:
        """Nodes in the order of the skeleton's joints, and all of them as a skeleton.

        Sizes are worked into the distances between joints. Where the file has a skin, only its
        joints keep their names, so that no mesh is taken for one.
        """
        nodes = [self._entry(node, "a node") for node in self._list("nodes")]
        if not 1 <= len(nodes) <= MOST_JOINTS:
            raise self._error(f"has {len(nodes)} nodes; expected 1 to {MOST_JOINTS}")
        parents = [-1] * len(nodes)
        for number, node in enumerate(nodes):
            for child in self._items(node, "children"):
                below = self._index(child, len(nodes), "node")
                if parents[below] >= 0 or below == number:
                    raise self._error(f"hangs node {below} on two others, or on itself")
                parents[below] = number
        joints = {
            self._index(joint, len(nodes), "node")
            for skin in self._list("skins")
            for joint in self._items(self._entry(skin, "a skin"), "joints")
        }
        order = [int(node) for node in in_tree_order(parents)]
        place = {node: joint for joint, node in enumerate(order)}
        offsets, rests = np.zeros((len(nodes), 3)), np.zeros((len(nodes), 4))
        sizes = np.ones(len(nodes))
        self._scales = np.ones(len(nodes))
        for joint, number in enumerate(order):
            offset, rests[joint], size = self._transform(nodes[number])
            above = sizes[place[parents[number]]] if parents[number] >= 0 else 1.0
            self._scales[joint], sizes[joint] = above, above * size
            if not 1 / LARGEST <= sizes[joint] <= LARGEST:
                raise self._error("scales its nodes to nothing, or beyond all measure")
            offsets[joint] = offset * above
        names = tuple(
            _legible(nodes[number].get("name", f"node {number}"))
            if not joints or number in joints
            else ""
            for number in order
        )
        above_each = tuple(
            place[parents[number]] if parents[number] >= 0 else -1 for number in order
        )
        return order, Skeleton(names, above_each, offsets, rests)

    def _transform(self, node: Mapping[str, Any]) -> tuple[Array, Array, float]:
        """Translation (3,), rotation (4,) wxyz and mean size of a node."""
        if "matrix" in node:
            matrix = self._numbers(node["matrix"], 16).reshape(4, 4).T
            scale = np.linalg.norm(matrix[:3, :3], axis=0)
            if not (scale > 1e-12).all():
                raise self._error("has a node whose matrix flattens it")
            turn = matrix[:3, :3] / scale
            return matrix[:3, 3], from_axes(turn[:, 0], turn[:, 1], turn[:, 2]), _mean(scale)
        offset = self._numbers(node.get("translation", (0, 0, 0)), 3)
        x, y, z, w = self._numbers(node.get("rotation", (0, 0, 0, 1)), 4)
        scale = self._numbers(node.get("scale", (1, 1, 1)), 3)
        return offset, normalized(np.array([w, x, y, z])), _mean(scale)

    def _numbers(self, value: Any, count: int) -> Array:
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.zeros(0)
        if array.shape != (count,) or not (np.abs(array) <= LARGEST).all():
            raise self._error(f"has a node that is not placed by {count} finite numbers")
        return array

    # -- key frames ----------------------------------------------------------------------------

    def _track(self, sampler: Mapping[str, Any], width: int) -> tuple[Array, Array]:
        """Times (K,) and values (K, width) of a sampler; rotations as wxyz."""
        times = self._accessor(sampler.get("input"), 1)[:, 0]
        values = self._accessor(sampler.get("output"), width)
        if sampler.get("interpolation") == "CUBICSPLINE":
            values = values[1::3]  # between its tangents; these are replaced by straight lines
        if len(values) != len(times) or (np.diff(times) < 0).any() or times[0] < 0:
            raise self._error(
                f"has {len(times)} key times for {len(values)} values, or times that do not rise"
            )
        return times, values[:, [3, 0, 1, 2]] if width == 4 else values

    def _accessor(self, number: Any, width: int) -> Array:
        """The finite numbers (K, width) of an accessor, checked to lie within the file."""
        accessor = self._entry(self._pick(self._list("accessors"), number, "accessor"), "accessor")
        if WIDTHS.get(str(accessor.get("type"))) != width or "sparse" in accessor:
            raise self._error(f"has an accessor of type {accessor.get('type')!r} where {width} "
                              "numbers a row were expected, in one piece")  # fmt: skip
        kind = np.dtype(TYPES.get(accessor.get("componentType", 0), "V0"))
        if kind.itemsize == 0:
            raise self._error("has an accessor of an unknown number format")
        view = self._entry(
            self._pick(self._list("bufferViews"), accessor.get("bufferView"), "buffer view"), "it"
        )
        held = len(self._bytes)
        begin = self._index(view.get("byteOffset", 0), held + 1, "byte")
        length = self._index(view.get("byteLength"), held - begin + 1, "byte")
        first = self._index(accessor.get("byteOffset", 0), length + 1, "byte")
        element = kind.itemsize * width
        stride = self._index(view.get("byteStride", element), 253, "byte")
        most = 0 if stride < element else max(0, (length - first - element) // stride + 1)
        count = self._index(accessor.get("count"), most + 1, "row")
        if count == 0:
            raise self._error("has an accessor without rows")
        with np.errstate(invalid="ignore"):  # of NaN, which is refused below
            array = np.ndarray(
                (count, width), kind, self._bytes, begin + first, (stride, kind.itemsize)
            ).astype(np.float64)
        if kind.kind != "f":
            array /= np.iinfo(kind).max
        if not (np.abs(array) <= LARGEST).all():
            raise self._error(f"has key frames that are NaN or infinite, or beyond {LARGEST:g}")
        return array

    # -- what a description may hold -----------------------------------------------------------

    def _error(self, problem: str) -> InvalidInputError:
        return InvalidInputError(f"{self._name!r} {problem}.")

    def _entry(self, value: Any, what: str) -> Mapping[str, Any]:
        if not isinstance(value, dict):
            raise self._error(f"is damaged: {what} is no object")
        return value

    def _items(self, entry: Mapping[str, Any], name: str) -> Sequence[Any]:
        value = entry.get(name, [])
        if not isinstance(value, list):
            raise self._error(f"is damaged: {name} is no list")
        return value

    def _list(self, name: str) -> Sequence[Any]:
        return self._items(self._told, name)

    def _index(self, value: Any, below: int, what: str) -> int:
        if type(value) is not int or not 0 <= value < below:
            raise self._error(f"asks for {what} {str(value)[:40]!r} of {below}; it is damaged")
        return value

    def _pick(self, items: Sequence[Any], number: Any, what: str) -> Any:
        return items[self._index(number, len(items), what)]


def sampled(times_s: Array, values: Array, moments: Array, interpolation: str) -> Array:
    """`values` (K, width) of key times (K,) at `moments` (N,); turns along the shorter way."""
    after = np.searchsorted(times_s, moments, "right")
    before = np.clip(after - 1, 0, len(times_s) - 1)
    after = np.minimum(after, len(times_s) - 1)
    gap = np.maximum(times_s[after] - times_s[before], 1e-9)
    share = np.clip((moments - times_s[before]) / gap, 0.0, 1.0)
    if interpolation == "STEP":
        share = np.zeros_like(share)
    if values.shape[1] == 4:
        return slerp(values[before], values[after], share)
    return np.asarray(values[before] + share[:, None] * (values[after] - values[before]))


def _mean(scale: Array) -> float:
    return float(np.cbrt(np.abs(np.prod(scale))))


def _legible(name: Any) -> str:
    """A name as a page can show it: short, and without halves of letters."""
    return str(name)[:80].encode("utf-8", "replace").decode()
