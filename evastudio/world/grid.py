"""A square of cells without an edge, and people in them who face one of eight ways.

Cells are whole numbers (x, y), wrapped at the edge where that matters; ways are counted
counter-clockwise from the x axis, 0 to 7.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evastudio.world.spaces import Array

Whole = NDArray[np.int64]

EIGHTH = np.pi / 4
AHEAD = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
"""The cell that each of the eight ways leads to."""
IN_A_ROW = 5
"""No more free cells than this are counted."""


def eighths(heading: Array) -> Whole:
    """Which of the eight ways `heading` points, rad."""
    return np.asarray(np.rint(heading / EIGHTH).astype(np.int64) % 8)


def wrapped(cells: Whole, side: int) -> Whole:
    """`cells` (..., 2) on the ground, from 0 to `side` - 1."""
    return np.asarray(cells % side)


def occupied(cells: Whole, side: int) -> NDArray[np.bool_]:
    """Which cells hold somebody, (worlds, side, side), rows by y, for `cells` (worlds, N, 2)."""
    ground = np.zeros((len(cells), side, side), dtype=np.bool_)
    spots = wrapped(cells, side)
    ground[np.arange(len(cells))[:, None], spots[:, :, 1], spots[:, :, 0]] = True
    return ground


def looked_up(ground: NDArray[np.bool_], cells: Whole) -> NDArray[np.bool_]:
    """`ground` (worlds, side, side) at `cells` (worlds, ..., 2) on it."""
    world = np.arange(len(ground)).reshape(-1, *(1,) * (cells.ndim - 2))
    return np.asarray(ground[world, cells[..., 1], cells[..., 0]])


def window(ahead: bool, reach: int) -> Whole:
    """The cells within `reach` of one's own for each way one may face, nearest first.

    Shape (8, K, 2). Of cells equally far those more ahead come first, then those to the left.
    `ahead` leaves out those to the sides and behind.
    """
    span = np.arange(-reach, reach + 1)
    cells = np.stack(np.meshgrid(span, span), axis=-1).reshape(-1, 2)
    far = np.hypot(cells[:, 0], cells[:, 1])
    cells, far = cells[(far > 0) & (far <= reach)], far[(far > 0) & (far <= reach)]
    tables = []
    for way in range(8):
        bearing = np.arctan2(cells[:, 1], cells[:, 0]) - way * EIGHTH
        bearing = np.remainder(bearing + np.pi - 1e-9, 2 * np.pi) - np.pi + 1e-9
        order = np.lexsort((-bearing, np.round(np.abs(bearing), 6), far))
        if ahead:
            order = order[np.abs(bearing[order]) < np.pi / 2 - 1e-6]
        tables.append(cells[order])
    least = min(len(table) for table in tables)
    return np.stack([table[:least] for table in tables])


def nearest(
    cells: Whole, facing: Whole, side: int, tables: Sequence[Whole], count: int
) -> tuple[Array, NDArray[np.bool_]]:
    """The cells from everybody to the `count` nearest others, and whether there are so many.

    cells: shape (worlds, N, 2). facing: shape (worlds, N). `tables` are of `window`, each wider
    than the one before: who finds too few in one is looked for in the next. Shapes
    (worlds, N, count, 2) and (worlds, N, count).
    """
    ground = occupied(cells, side)
    own = wrapped(cells, side)
    offsets = np.zeros((*facing.shape, count, 2))
    seen = np.zeros((*facing.shape, count), dtype=np.bool_)
    left = np.nonzero(np.ones(facing.shape, dtype=np.bool_))
    for table in tables:
        around = table[facing[left]]
        spots = wrapped(own[left][:, None] + around, side)
        there = ground[left[0][:, None], spots[..., 1], spots[..., 0]]
        rank = np.cumsum(there, axis=1, dtype=np.uint8)
        row = np.arange(len(around))
        for number in range(count):
            at = (there & (rank == number + 1)).argmax(axis=1)
            offsets[left[0], left[1], number] = around[row, at]
            seen[left[0], left[1], number] = there[row, at] & (rank[row, at] == number + 1)
        short = ~seen[left].all(axis=1)
        left = (left[0][short], left[1][short])
    return offsets, seen


def turned_back(offsets: Array, facing: Whole) -> Array:
    """`offsets` (..., K, 2) as one sees them who is `facing` (...) that way: ahead, and left."""
    angle = facing * EIGHTH
    cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
    x, y = offsets[..., 0], offsets[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def clearances(cells: Whole, facing: Whole, side: int, ways: Sequence[int]) -> Array:
    """Free cells in a row to each of `ways`, eighths from the way one faces, (worlds, N, ways)."""
    ground = occupied(cells, side)
    rooms = []
    for aside in ways:
        step = AHEAD[(facing + aside) % 8]
        free = np.zeros(facing.shape)
        open_ = np.ones(facing.shape, dtype=np.bool_)
        for far in range(1, IN_A_ROW + 1):
            open_ = open_ & ~looked_up(ground, wrapped(cells + far * step, side))
            free += open_
        rooms.append(free)
    return np.stack(rooms, axis=2)
