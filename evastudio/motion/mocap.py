"""Reading captured clips in DeepMimic's form: JSON with 44 numbers a frame (Peng et al. 2018)."""

from __future__ import annotations

import json

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.clip import Clip, fitting
from evastudio.motion.rotations import about, normalized, slerp
from evastudio.motion.skeleton import LARGEST, Skeleton
from evastudio.world.spaces import Array, finite_rows

MOST_BYTES = 16_000_000
WIDTH = 44
JOINTS: tuple[tuple[str, int, tuple[float, float, float], int], ...] = (
    ("hips", -1, (0, 0, 0), 4),
    ("chest", 0, (0, 0.236151, 0), 4),
    ("neck", 1, (0, 0.223894, 0), 4),
    ("right_hip", 0, (0, 0, 0.084887), 4),
    ("right_knee", 3, (0, -0.421546, 0), 1),
    ("right_ankle", 4, (0, -0.40987, 0), 4),
    ("right_shoulder", 1, (-0.02405, 0.24350, 0.18311), 4),
    ("right_elbow", 6, (0, -0.274788, 0), 1),
    ("left_hip", 0, (0, 0, -0.084887), 4),
    ("left_knee", 8, (0, -0.421546, 0), 1),
    ("left_ankle", 9, (0, -0.40987, 0), 4),
    ("left_shoulder", 1, (-0.02405, 0.24350, -0.18311), 4),
    ("left_elbow", 11, (0, -0.274788, 0), 1),
    ("right_wrist", 7, (0, -0.258947, 0), 0),
    ("left_wrist", 12, (0, -0.258947, 0), 0),
)
"""Name, parent, offset in metres (x ahead, y up, z right) and how many numbers turn it.

One number is the angle of a knee or elbow about z.
"""


def read_mocap(data: bytes, name: str) -> Clip:
    """The clip in a file of DeepMimic's. Raises InvalidInputError where it is none."""
    if len(data) > MOST_BYTES:
        raise InvalidInputError(f"{name!r} has {len(data)} bytes; it may have {MOST_BYTES}.")
    try:
        told = json.loads(data)
        frames = told["Frames"]
        fitting(name, len(frames), len(JOINTS))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, InvalidInputError):
            raise
        raise InvalidInputError(
            f"{name!r} is no captured clip: expected JSON with a list 'Frames' "
            f"({type(error).__name__})."
        ) from None
    numbers = finite_rows(frames, WIDTH, f"frames of {name!r}", "duration, root, joints")
    if (np.abs(numbers) > LARGEST).any():
        raise InvalidInputError(f"The frames of {name!r} hold numbers beyond {LARGEST:g}.")
    lasting = np.maximum(numbers[:-1, 0], 0.0)
    times = np.concatenate([[0.0], np.cumsum(lasting)])
    if not 0.05 <= times[-1] <= 3600.0 or lasting.min() <= 0:
        raise InvalidInputError(
            f"{name!r} lasts {times[-1]:g} s; expected moments that last, 0.05 s to an hour in all."
        )
    rate_hz = len(lasting) / times[-1]
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(numbers), len(JOINTS), 1))
    column = 4
    for joint, (_, _, _, width) in enumerate(JOINTS):
        if width == 4:
            rotations[:, joint] = numbers[:, column : column + 4]
        elif width == 1:
            rotations[:, joint] = about(2, numbers[:, column])
        column += width
    offsets = np.array([offset for _, _, offset, _ in JOINTS], dtype=np.float64)
    translations = np.tile(offsets, (len(numbers), 1, 1))
    translations[:, 0] = numbers[:, 1:4]
    skeleton = Skeleton(
        tuple(joint for joint, *_ in JOINTS), tuple(parent for _, parent, *_ in JOINTS), offsets
    )
    return Clip(name, skeleton, rate_hz, *evened(times, rate_hz, translations, rotations))


def evened(
    times_s: Array, rate_hz: float, translations: Array, rotations: Array
) -> tuple[Array, Array]:
    """The same movement at evenly spaced moments."""
    moments = np.arange(round(times_s[-1] * rate_hz) + 1) / rate_hz
    after = np.clip(np.searchsorted(times_s, moments, "right"), 1, len(times_s) - 1)
    gap = np.maximum(times_s[after] - times_s[after - 1], 1e-9)
    share = np.clip((moments - times_s[after - 1]) / gap, 0.0, 1.0)[:, None]
    moved = translations[after - 1] + share[..., None] * (
        translations[after] - translations[after - 1]
    )
    turns = normalized(rotations)
    return moved, slerp(turns[after - 1], turns[after], share)
