"""Every pose of every movement in one table: what is shown is a weighted sum of its rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from evastudio.motion.body import HALF_HIPS
from evastudio.motion.gait import Gait
from evastudio.motion.poses import Poses
from evastudio.world.spaces import Array

UPPER = slice(0, 36)
FEET = slice(36, 44)
TURNS = slice(0, 44)
HINGES = slice(44, 50)
ROOT = slice(50, 53)
ANKLES = slice(53, 59)
STROKES = slice(59, 61)
DUTIES = slice(61, 63)
PLACES = slice(63, 67)
"""Ahead and aside of each track that its foot stands."""
CHANNELS = 67
ASIDE = 0.9 * HALF_HIPS
"""How far aside of the middle feet are that stay where they stood."""

Floats = NDArray[np.float32]
Whole = NDArray[Any]
"""Integers."""


def rows(poses: Poses) -> Array:
    """`poses` as rows of the table, shape (F, CHANNELS), their feet where they are."""
    flat = [
        part.reshape(len(poses), -1)
        for part in (poses.upper, poses.feet, poses.hinges, poses.root, poses.ankles)
    ]
    table = np.concatenate([*flat, np.zeros((len(poses), CHANNELS - STROKES.start))], axis=1)
    table[:, PLACES] = (0.0, ASIDE, 0.0, -ASIDE)
    return table


def resting_rows(poses: Poses) -> Array:
    """The same for poses that rest on their feet; the last row repeats the first."""
    table = rows(poses)
    table[:, PLACES] = poses.ankles[:, :, :2].mean(axis=0).ravel()
    return np.concatenate([table, table[:1]])


def gait_rows(gait: Gait) -> Array:
    """A cycle as rows, its feet beside their strokes; the last row repeats the first."""
    table = rows(gait.poses)
    table[:, STROKES], table[:, DUTIES] = gait.strokes, gait.duties
    table[:, [ANKLES.start, ANKLES.start + 3]] -= gait.strokes * gait.stride_m
    for foot, touchdown in enumerate((0, len(table) // 2)):
        middle = round(touchdown + gait.duties[foot] / 2 * len(table)) % len(table)
        first = ANKLES.start + 3 * foot
        table[:, PLACES.start + 2 * foot : PLACES.start + 2 * foot + 2] = table[
            middle, first : first + 2
        ]
    return np.concatenate([table, table[:1]])


class Table:
    """Rows to be mixed."""

    def __init__(self) -> None:
        self._blocks: list[Array] = []
        self._count = 0
        self._rows: Floats = np.zeros((0, CHANNELS), dtype=np.float32)

    def add(self, block: Array) -> int:
        """Append rows and return the index of the first."""
        start = self._count
        self._blocks.append(block)
        self._count += len(block)
        self._rows = np.concatenate(self._blocks).astype(np.float32)
        return start

    def mixed(self, indices: Whole, weights: Floats) -> Floats:
        """Sums of the rows `indices` (N, K), each times its weight (N, K).

        Returns shape (CHANNELS, N), one long row for each channel.
        """
        people, terms = indices.shape
        ends = np.arange(0, people * terms + 1, terms)
        mixing = sparse.csr_array(
            (weights.reshape(-1), indices.reshape(-1), ends), shape=(people, self._count)
        )
        mixing.eliminate_zeros()
        return np.ascontiguousarray((mixing @ self._rows).T)
