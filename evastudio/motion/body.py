"""The shipped body: how long its limbs are, and where its joints sit. Size 1 is 1.75 m tall."""

from __future__ import annotations

import numpy as np

UPPER = (
    "hips",
    "chest",
    "head",
    "left_upper_arm",
    "right_upper_arm",
    "left_forearm",
    "right_forearm",
    "left_hand",
    "right_hand",
)
"""Joints whose rotations a pose holds, each in its parent's frame; the hips' in the path's."""
PARENTS = (-1, 0, 1, 1, 1, 3, 4, 5, 6)
"""Index into `UPPER` of what each joint hangs on."""
SIDES = ("left", "right")
THIGH = 0.43
SHANK = 0.41
ANKLE = 0.085
"""Height of the ankle above the sole."""
LEG = THIGH + SHANK + ANKLE
"""From the hip to the ground."""
WAIST = 0.10
"""From the height of the hips to where the chest turns."""
NECK = 0.43
"""From the waist to where the head turns."""
SHOULDER = 0.36
"""From the waist to the height of the shoulders."""
HALF_SHOULDERS = 0.185
HALF_HIPS = 0.095
UPPER_ARM = 0.27
FOREARM = 0.24
HEEL = -0.075
"""Where the sole touches the ground behind the ankle, along the foot."""
BALL = 0.125
"""Where the sole bends and leaves the ground last, along the foot."""

OFFSETS = np.array(
    [
        (0, 0, 0),
        (0, 0, WAIST),
        (0, 0, NECK),
        (0, HALF_SHOULDERS, SHOULDER),
        (0, -HALF_SHOULDERS, SHOULDER),
        (0, 0, -UPPER_ARM),
        (0, 0, -UPPER_ARM),
        (0, 0, -FOREARM),
        (0, 0, -FOREARM),
    ],
    dtype=np.float64,
)
"""Shape (9, 3), metres: each joint of `UPPER` in its parent's frame."""
HIPS = np.array([(0, HALF_HIPS, 0), (0, -HALF_HIPS, 0)], dtype=np.float64)
"""Shape (2, 3), metres: where the legs hang, in the frame of the hips."""
SOLES = np.array([(HEEL, 0, -ANKLE), (BALL, 0, -ANKLE)], dtype=np.float64)
"""Shape (2, 3), metres: heel and ball, the points a foot stands on, in its frame."""
