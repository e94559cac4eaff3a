"""Files of clips, written here from the shipped walk: as other programs would export it."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from evastudio.motion.clip import Clip
from evastudio.motion.figures import JOINTS, Figures
from evastudio.motion.moment import Activity, Moment
from evastudio.motion.rotations import inverse, product
from evastudio.motion.skeleton import Skeleton

NAMES = dict(
    zip(
        JOINTS,
        (
            *("Hips", "Spine", "Head", "LeftArm", "RightArm", "LeftForeArm", "RightForeArm"),
            *("LeftHand", "RightHand", "LeftUpLeg", "RightUpLeg", "LeftLeg", "RightLeg"),
            *("LeftFoot", "RightFoot"),
        ),
        strict=True,
    )
)
ABOVE = (-1, 0, 1, 1, 1, 3, 4, 5, 6, 0, 0, 9, 10, 11, 12)
FIGURES = Figures()


def turned(vectors: np.ndarray) -> np.ndarray:
    """From x ahead, y left, z up to y up, z ahead, x left, as most programs have it."""
    return np.roll(vectors, -1, axis=-1)


def walking(speed: float = 1.2, seconds: float = 2.4, moves: bool = True) -> Clip:
    """A walk in centimetres, y up, with its root moving on or on the spot."""
    rate = 60.0
    time = np.arange(round(seconds * rate) + 1) / rate
    count = len(time)
    place = np.zeros((count, 2))
    place[:, 0] = speed * time if moves else 0.0
    cadence = float(FIGURES.cadence(speed))
    moment = Moment(place, np.zeros(count), np.full(count, speed), cadence * time)
    joints = FIGURES.joints(moment)
    rest = FIGURES.joints(
        Moment(np.zeros((1, 2)), np.zeros(1), activities=np.array([Activity.STAND]))
    )
    return clip_of(
        100 * joints.positions.astype(np.float64), joints.wxyzs.astype(np.float64), rest, rate
    )


def clip_of(positions: np.ndarray, wxyzs: np.ndarray, rest: Any, rate: float) -> Clip:
    straight = np.zeros((15, 3))
    for joint, parent in enumerate(ABOVE):
        if parent >= 0:
            length = np.linalg.norm(rest.positions[joint, 0] - rest.positions[parent, 0]) * 100
            hangs = "leg" in NAMES[JOINTS[joint]].lower() or parent > 2
            straight[joint] = (0, 0, -length if hangs else length)
    straight[[3, 4]] = [(0, 18.5, 36), (0, -18.5, 36)]
    straight[[9, 10]] = [(0, 9.5, 0), (0, -9.5, 0)]
    local = []
    for joint, parent in enumerate(ABOVE):
        turn = wxyzs[joint] if parent < 0 else product(inverse(wxyzs[parent]), wxyzs[joint])
        local.append(np.concatenate([turn[:, :1], turned(turn[:, 1:])], axis=1))
    translations = np.tile(turned(straight), (positions.shape[1], 1, 1))
    translations[:, 0] = turned(positions[0])
    skeleton = Skeleton(tuple(NAMES[joint] for joint in JOINTS), ABOVE, turned(straight))
    return Clip("walk", skeleton, rate, translations, np.stack(local, axis=1))


def bvh(clip: Clip) -> str:
    """`clip` as the text of a BVH file."""
    skeleton = clip.skeleton
    lines = ["HIERARCHY"]

    def write(joint: int, depth: int) -> None:
        pad = "  " * depth
        kind = "JOINT" if depth else "ROOT"
        offset = " ".join(f"{part:.6f}" for part in skeleton.offsets[joint])
        channels = "Zrotation Xrotation Yrotation"
        head = f"6 Xposition Yposition Zposition {channels}" if not depth else f"3 {channels}"
        lines.extend([f"{pad}{kind} {skeleton.names[joint]}", f"{pad}{{", f"{pad}OFFSET {offset}"])
        lines.append(f"{pad}CHANNELS {head}")
        order.append(joint)
        below = [one for one, parent in enumerate(skeleton.parents) if parent == joint]
        for one in below:
            write(one, depth + 1)
        if not below:
            lines.append(f"{pad}End Site\n{pad}{{\n{pad}OFFSET 0 0 5\n{pad}}}")
        lines.append(f"{pad}}}")

    order: list[int] = []
    write(0, 0)
    turns = Rotation.from_quat(clip.rotations[..., [1, 2, 3, 0]].reshape(-1, 4))
    angles = turns.as_euler("ZXY", degrees=True).reshape(len(clip.rotations), -1, 3)
    lines += ["MOTION", f"Frames: {len(angles)}", f"Frame Time: {1 / clip.rate_hz:.8f}"]
    for root, frame in zip(clip.translations[:, 0], angles, strict=True):
        numbers = [*root, *frame[order].ravel()]
        lines.append(" ".join(f"{number:.5f}" for number in numbers))
    return "\n".join(lines) + "\n"


def described(clip: Clip) -> tuple[dict[str, Any], bytes]:
    """`clip` as the description and the data of a glTF file."""
    skeleton = clip.skeleton
    nodes: list[dict[str, Any]] = []
    for joint, name in enumerate(skeleton.names):
        below = [one for one, parent in enumerate(skeleton.parents) if parent == joint]
        node = {"name": name, "translation": skeleton.offsets[joint].tolist(), "children": below}
        nodes.append(node if below else {key: node[key] for key in ("name", "translation")})
    data = b""
    views, accessors, samplers, channels = [], [], [], []

    def add(array: np.ndarray, kind: str) -> int:
        nonlocal data
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": 5126,
                "count": len(array),
                "type": kind,
            }
        )
        data += array.tobytes()
        return len(accessors) - 1

    times = add((np.arange(len(clip.rotations)) / clip.rate_hz).astype("<f4"), "SCALAR")
    tracks = [(0, "translation", clip.translations[:, 0], "VEC3")]
    tracks += [
        (joint, "rotation", clip.rotations[:, joint][:, [1, 2, 3, 0]], "VEC4")
        for joint in range(len(nodes))
    ]
    for joint, path, values, kind in tracks:
        output = add(values.astype("<f4"), kind)
        samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
        target = {"node": joint, "path": path}
        channels.append({"sampler": len(samplers) - 1, "target": target})
    told = {
        "asset": {"version": "2.0"},
        "nodes": nodes,
        "skins": [{"joints": list(range(len(nodes)))}],
        "animations": [{"name": "walk", "samplers": samplers, "channels": channels}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    return told, data


def packed(told: Any, data: bytes) -> bytes:
    """A .glb file of a description and its data."""
    text = told if isinstance(told, bytes) else json.dumps(told).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def glb(clip: Clip, *names: str) -> bytes:
    """`clip` as a .glb file, once under each of `names`."""
    told, data = described(clip)
    one = told["animations"][0]
    told["animations"] = [{**one, "name": name} for name in names or ("walk",)]
    return packed(told, data)
