"""Reading BVH: a skeleton and one clip as text (Biovision; Meredith and Maddock 2001)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.clip import Clip, fitting
from evastudio.motion.rotations import about, product
from evastudio.motion.skeleton import LARGEST, MOST_JOINTS, Skeleton
from evastudio.world.spaces import Array

CHANNELS = {
    f"{axis}{kind}": (kind, index)
    for kind in ("position", "rotation")
    for index, axis in enumerate("XYZ")
}
MOST_BYTES = 64_000_000
MOST_LETTERS = 2_000_000
"""Of the hierarchy: two thousand for each joint there may be."""
DEEPEST = 200


def read_bvh(data: bytes, name: str) -> Clip:
    """The clip in the text of a BVH file; `name` is used for it and in errors.

    Raises InvalidInputError where the file is broken, or larger than a clip may be.
    """
    if len(data) > MOST_BYTES:
        raise InvalidInputError(
            f"{name!r} has {len(data)} bytes; a BVH file may have {MOST_BYTES}. Cut it first."
        )
    text = data.decode("utf-8", errors="replace")
    start = re.search(r"^[ \t]*MOTION\b", text, re.MULTILINE)  # \s would try every line from each
    if not re.match(r"\s*HIERARCHY\b", text) or start is None:
        raise InvalidInputError(
            f"{name!r} is no BVH file: it must begin with HIERARCHY and hold a line MOTION."
        )
    if start.start() > MOST_LETTERS:
        raise InvalidInputError(
            f"The hierarchy of {name!r} has {start.start()} letters; that of {MOST_JOINTS} joints "
            f"needs no more than {MOST_LETTERS}."
        )
    hierarchy = _Hierarchy(name, text[: start.start()])
    width = sum(len(channels) for channels in hierarchy.channels)
    head = re.match(
        r"\s*Frames:\s*(\d{1,18})\s+Frame\s+Time:\s*(\S{1,40})", text[start.end() :], re.IGNORECASE
    )
    if head is None:
        raise InvalidInputError(
            f"After MOTION, {name!r} must say 'Frames: N' and 'Frame Time: seconds'."
        )
    frames, step_s = int(head[1]), _number(head[2], name)
    body = text[start.end() + head.end() :]
    fitting(name, frames, len(hierarchy.names))
    if not 1e-4 <= step_s <= 10.0:
        raise InvalidInputError(f"{name!r} has a frame time of {step_s} s; expected 0.0001 to 10.")
    if len(body) < 2 * frames * width - 1:
        raise InvalidInputError(
            f"{name!r} claims {frames} frames of {width} numbers, more than its text can hold; it "
            "is cut off or damaged."
        )
    words = body.split(None, frames * width)
    if len(words) != frames * width:
        held = "more" if len(words) > frames * width else str(len(words))
        raise InvalidInputError(
            f"{name!r} claims {frames} frames of {width} numbers, but holds {held} instead of "
            f"{frames * width}."
        )
    try:
        numbers = np.array(words, dtype=np.float64)
    except ValueError as error:
        raise InvalidInputError(f"A frame of {name!r} is not made of numbers ({error}).") from None
    if not (np.abs(numbers) <= LARGEST).all():
        raise InvalidInputError(
            f"The frames of {name!r} hold NaN or infinite numbers, or some beyond {LARGEST:g}; "
            "export them anew."
        )
    return hierarchy.clip(numbers.reshape(frames, width), 1.0 / step_s)


def _number(word: str, name: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidInputError(f"{name!r} holds {word[:40]!r} where a number was expected.")
    return value


class _Hierarchy:
    """The first half of a file: joints, and which numbers of a frame move them."""

    def __init__(self, name: str, text: str) -> None:
        self._name = name
        self.names: list[str] = []
        self.parents: list[int] = []
        self.offsets: list[list[float]] = []
        self.channels: list[list[str]] = []
        words = iter(re.findall(r"[{}]|[^\s{}]+", text)[1:])
        while (word := next(words, None)) is not None:
            if word.upper() != "ROOT" or self.names:
                raise InvalidInputError(
                    f"{name!r} has {word[:40]!r} where its one ROOT joint was expected."
                )
            self._joint(words)

    def _joint(self, words: Iterator[str]) -> None:
        """Read the root and all below it, with a stack of open joints instead of recursion."""
        open_joints = [self._begin(words, -1)]
        while open_joints:
            word = self._next(words)
            kind = word.upper()
            joint = open_joints[-1]
            if word == "}":
                open_joints.pop()
            elif kind == "OFFSET":
                self.offsets[joint] = [self._coordinate(words) for _ in range(3)]
            elif kind == "CHANNELS":
                self._channels(words, joint)
            elif kind == "JOINT" and len(open_joints) < DEEPEST:
                open_joints.append(self._begin(words, joint))
            elif kind == "END":
                self._end(words)
            else:
                raise InvalidInputError(
                    f"{self._name!r} has {word[:40]!r} in joint {self.names[joint]!r}; expected "
                    f"OFFSET, CHANNELS, JOINT, End Site or a closing brace, at most {DEEPEST} deep."
                )

    def _begin(self, words: Iterator[str], parent: int) -> int:
        parts = []
        while (word := self._next(words)) != "{":
            parts.append(word)
            if len(parts) > 8:
                raise InvalidInputError(f"A joint of {self._name!r} lacks its opening brace.")
        if len(self.names) >= MOST_JOINTS:
            raise InvalidInputError(
                f"{self._name!r} has more than {MOST_JOINTS} joints; no body needs as many."
            )
        self.names.append(" ".join(parts)[:80])
        self.parents.append(parent)
        self.offsets.append([0.0, 0.0, 0.0])
        self.channels.append([])
        return len(self.names) - 1

    def _channels(self, words: Iterator[str], joint: int) -> None:
        count = self._next(words)
        if not count.isascii() or not count.isdigit() or int(count[:3]) > 6 or self.channels[joint]:
            raise InvalidInputError(
                f"Joint {self.names[joint]!r} of {self._name!r} has {count[:40]!r} channels; "
                "expected one list of at most 6."
            )
        for _ in range(int(count)):
            word = self._next(words)
            channel = word[:1].upper() + word[1:].lower()
            if channel not in CHANNELS or channel in self.channels[joint]:
                raise InvalidInputError(
                    f"Joint {self.names[joint]!r} of {self._name!r} has the channel "
                    f"{word[:40]!r}; expected {', '.join(CHANNELS)}, each once."
                )
            self.channels[joint].append(channel)

    def _end(self, words: Iterator[str]) -> None:
        """Skip an end site, which says only how long the last bone is."""
        for expected in ("SITE", "{", "OFFSET", None, None, None, "}"):
            if expected is None:
                self._coordinate(words)
            elif self._next(words).upper() != expected:
                raise InvalidInputError(f"An end site of {self._name!r} is damaged.")

    def _coordinate(self, words: Iterator[str]) -> float:
        return _number(self._next(words), self._name)

    def _next(self, words: Iterator[str]) -> str:
        word = next(words, None)
        if word is None:
            raise InvalidInputError(
                f"The hierarchy of {self._name!r} ends in the middle; a brace is missing."
            )
        return word

    def clip(self, numbers: Array, rate_hz: float) -> Clip:
        if not self.names:
            raise InvalidInputError(f"{self._name!r} has no ROOT joint.")
        offsets = np.array(self.offsets)
        frames, joints = len(numbers), len(self.names)
        translations = np.tile(offsets, (frames, 1, 1))
        rotations = np.tile([1.0, 0.0, 0.0, 0.0], (frames, joints, 1))
        column = 0
        for joint, channels in enumerate(self.channels):
            for channel in channels:
                kind, axis = CHANNELS[channel]
                if kind == "position":
                    translations[:, joint, axis] = numbers[:, column]
                else:
                    turn = about(axis, np.radians(numbers[:, column]))
                    rotations[:, joint] = product(rotations[:, joint], turn)
                column += 1
        skeleton = Skeleton(tuple(self.names), tuple(self.parents), offsets)
        return Clip(self._name, skeleton, rate_hz, translations, rotations)
