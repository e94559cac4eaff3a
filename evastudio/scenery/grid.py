"""A square of cells without an edge, and people in them who face one of eight ways.

Cells are whole numbers (x, y), wrapped at the edge where that matters; ways are counted
counter-clockwise from the x axis, 0 to 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.world.spaces import Array

Whole = NDArray[np.int64]

EIGHTH = np.pi / 4
AHEAD = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)])
"""The cell that each of the eight ways leads to."""
IN_A_ROW = 5
"""No more free cells than this are counted."""
FIRST_LOOKS = (20, 68)
"""How many of the cells around are looked at before the others, when the nearest are sought."""
BLOCK = 4096
"""People who look around at a time, to bound memory."""


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


@dataclass(frozen=True)
class Ground:
    """Who stands where, laid out flat with a margin, so that looking around needs no wrapping."""

    taken: NDArray[np.bool_]
    """Shape (worlds * width * width,), rows by y; the margin repeats the other side."""
    width: int
    """Cells along a side, margins included."""
    own: Whole
    """Where in `taken` everybody's own cell is, shape (worlds, N)."""

    @classmethod
    def of(cls, cells: Whole, side: int, margin: int) -> Ground:
        """For `cells` (worlds, N, 2), with a `margin` as wide as one looks."""
        spread = np.arange(-margin, side + margin) % side
        taken = occupied(cells, side).take(spread, axis=1).take(spread, axis=2)
        width = len(spread)
        spots = wrapped(cells, side) + margin
        world = np.arange(len(cells))[:, None] * width
        return cls(taken.reshape(-1), width, (world + spots[:, :, 1]) * width + spots[:, :, 0])

    def steps(self, offsets: Whole) -> Whole:
        """How far in `taken` a cell is from one that is `offsets` (..., 2) away."""
        return np.asarray(offsets[..., 1] * self.width + offsets[..., 0])


def nearest(cells: Whole, facing: Whole, side: int, table: Whole, count: int) -> Whole:
    """Which cells of the `table` of their way the `count` nearest others of everybody stand in.

    cells: shape (worlds, N, 2). facing: shape (worlds, N). `table` is of `window`. Shape
    (worlds, N, count), -1 where there are fewer.
    """
    ground = Ground.of(cells, side, int(np.abs(table).max()))
    steps = ground.steps(table)
    own, ways = ground.own.reshape(-1), facing.reshape(-1)
    found = np.full((len(own), count), -1)
    for start in range(0, len(own), BLOCK):
        left = np.arange(start, min(start + BLOCK, len(own)))
        # Few look far: those with enough people near are done after the first cells.
        for looked in (*FIRST_LOOKS, table.shape[1]):
            around = steps[ways[left], :looked]
            around += own[left, None]
            there = ground.taken.take(around)
            row = np.arange(len(left))
            for number in range(count):
                at = there.argmax(axis=1)
                found[left, number] = np.where(there[row, at], at, -1)
                there[row, at] = False
            left = left[found[left, -1] < 0]
    return found.reshape(*facing.shape, count)


def turned_back(offsets: Array, facing: Whole) -> Array:
    """`offsets` (..., K, 2) as one sees them who is `facing` (...) that way: ahead, and left."""
    angle = facing * EIGHTH
    cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
    x, y = offsets[..., 0], offsets[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def clearances(cells: Whole, facing: Whole, side: int, ways: Sequence[int]) -> Whole:
    """Free cells in a row to each of `ways`, eighths from the way one faces, (worlds, N, ways)."""
    ground = Ground.of(cells, side, IN_A_ROW)
    step = ground.steps(AHEAD[(np.arange(8)[:, None] + ways) % 8])[facing]
    place = np.repeat(ground.own[..., None], len(ways), axis=2)
    free = np.zeros(place.shape, dtype=np.int64)
    open_ = np.ones(place.shape, dtype=np.bool_)
    for _ in range(IN_A_ROW):
        place += step
        open_ &= ~ground.taken.take(place)
        free += open_
    return free


def granted(
    cells: Whole,
    facing: Whole,
    target: Whole,
    free: NDArray[np.bool_],
    steps: Whole,
    side: int,
) -> NDArray[np.bool_]:
    """Who of those that walk into a `free` cell gets it, (worlds, N).

    cells, target: where they are and want to be, (worlds, N, 2). facing: eighths, (worlds, N).
    The first in line, a line that begins with somebody else in each of `steps` (worlds,). Two who
    would cross at a corner claim that corner too.
    """
    worlds, people = free.shape
    shift = 7919 if people % 7919 else 7907
    turn = (np.arange(people) - steps[:, None] * shift) % people
    world = np.arange(worlds)[:, None]
    place = (world * side + target[:, :, 1]) * side + target[:, :, 0]
    first = np.full(worlds * side**2, people)
    np.minimum.at(first, place[free], turn[free])
    goes = free & (first[place] == turn)
    slant = goes & (facing % 2 == 1)
    low = wrapped(cells + np.minimum(AHEAD[facing], 0), side)
    corner = (world * side + low[:, :, 1]) * side + low[:, :, 0]
    first = np.full(worlds * side**2, people)
    np.minimum.at(first, corner[slant], turn[slant])
    return np.asarray(goes & (~slant | (first[corner] == turn)))
