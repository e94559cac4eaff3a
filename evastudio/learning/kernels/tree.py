"""A tree of boxes over points, eight children wide, built once and never changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evastudio.learning.kernels.lanes import LEAF
from evastudio.learning.kernels.sharing import share
from evastudio.learning.kernels.vectors import LANES

Floats = NDArray[np.float32]
FAR = np.float32(2e19)
"""Coordinate of slots that hold no point: its square is infinite, so none is ever near."""
NONE = np.int32(2**31 - 1)
"""Number of no point."""
SAMPLE = 256
"""Points that are looked at to choose where to split."""
POINTS_EACH = 10_000
"""Points that a processor takes at a time when building."""
(
    SIZE, INNER, NODES, CHILDREN, LEAVES, NUMBERS, TREE_LEAVES, ADDED, ADDED_NUMBERS, ADDED_LEAVES,
    OFFSET, SCALE, ACTIONS, OUTPUTS, K, INVERSE, TABLE,
) = range(17)  # fmt: skip
"""What stands where in the table that a kernel is given: addresses and numbers."""
LARGEST = 1e15
"""No component of a point or query is beyond this."""


@dataclass(frozen=True)
class Tree:
    """A balanced k-d tree whose nodes are laid out for `kernels.search`.

    Binary splits at the median of the component that varies most until at most 16 points are
    left; three binary levels then make one level of eight children.
    """

    nodes: Floats
    """Boxes of every node's children: (nodes, 2, size, 8)."""
    children: NDArray[np.int64]
    """First child of every node, shape (nodes,); from the number of nodes on they are leaves."""
    leaves: Floats
    """Points of every leaf, component by component: (leaves, size, 16)."""
    numbers: NDArray[np.int32]
    """Number of the point in each slot, NONE where there is none: (leaves, 16)."""


def build_tree(points: Floats, numbers: NDArray[np.int64]) -> Tree:
    """A tree over `points` (n, size) of those `numbers` (n,), n at least 1."""
    count, size = points.shape
    depth = 0
    while -(-count // (1 << depth)) > LEAF:
        depth += 1
    points, order = points.copy(), numbers.astype(np.int32)
    bounds = np.array([0, count])
    for level in range(depth):
        halves = np.empty((1 << (level + 1)) + 1, np.int64)
        _share(count, 1 << level, _split, points, order, bounds, halves)
        bounds = halves
    leaves = np.empty((1 << depth, size, LEAF), np.float32)
    slots = np.empty((1 << depth, LEAF), np.int32)
    boxes = np.empty((1 << depth, 2, size), np.float32)
    _share(count, 1 << depth, _pack, points, order, bounds, leaves, slots, boxes)
    parts: list[Floats] = []
    while True:  # from the lowest level up
        width = min(LANES, len(boxes))
        wide = np.full((len(boxes) // width, 2, size, LANES), FAR, np.float32)
        wide[..., :width] = boxes.reshape(-1, width, 2, size).transpose(0, 2, 3, 1)
        parts.insert(0, wide)
        if len(wide) == 1:
            break
        ends = wide[:, 0].min(axis=-1), wide[:, 1].max(axis=-1)
        boxes = np.stack(ends, axis=1)
    children = 1 + LANES * np.arange(sum(len(part) for part in parts))
    children[1:] += width - LANES  # the root may have fewer
    return Tree(np.concatenate(parts), children, leaves, slots)


def _share(count: int, nodes: int, kernel: Any, *arrays: Any) -> None:
    """Run a kernel for all nodes of a level, each processor some thousand points at a time."""
    step = max(1, POINTS_EACH * nodes // count)
    share(nodes, step, lambda first, last: kernel(first, last, *arrays))


def pack_leaves(points: Floats, numbers: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int32]]:
    """Any points (n, size) and their numbers laid out as the leaves of a tree are, in order."""
    count, size = points.shape
    leaves = -(-count // LEAF)
    rows = np.full((leaves * LEAF, size), FAR, np.float32)
    slots = np.full(leaves * LEAF, NONE, np.int32)
    rows[:count], slots[:count] = points, numbers
    columns = rows.reshape(leaves, LEAF, size).transpose(0, 2, 1)
    return np.ascontiguousarray(columns), slots.reshape(leaves, LEAF)


@njit(cache=True, nogil=True, error_model="numpy")
def _split(first, last, points, order, bounds, halves):
    """Part the points between two `bounds` at their median; the bounds of the halves."""
    for node in range(first, last):
        start, stop = bounds[node], bounds[node + 1]
        middle = (start + stop + 1) >> 1
        _select(points, order, start, stop, middle, _axis(points, start, stop))
        halves[2 * node], halves[2 * node + 1], halves[2 * node + 2] = start, middle, stop


@njit(cache=True, nogil=True, error_model="numpy")
def _axis(points, start, stop):
    """The component that varies most, by a sample."""
    size = points.shape[1]
    step = max(1, (stop - start) // SAMPLE)
    axis, widest = 0, -1.0
    for component in range(size):
        shift = np.float64(points[start, component])
        count, total, squares = 0, 0.0, 0.0
        for row in range(start, stop, step):
            value = points[row, component] - shift
            count += 1
            total += value
            squares += value * value
        variance = squares - total * total / count
        if variance > widest:
            axis, widest = component, variance
    return axis


@njit(cache=True, nogil=True, error_model="numpy")
def _select(points, order, start, stop, middle, axis):
    """Reorder rows from start to stop so that none before `middle` exceeds one after it."""
    size = points.shape[1]
    low, high = start, stop - 1
    while low < high:
        one, two, three = points[low, axis], points[(low + high) >> 1, axis], points[high, axis]
        pivot = max(min(one, two), min(max(one, two), three))
        left, right = low, high
        while left <= right:
            while points[left, axis] < pivot:
                left += 1
            while points[right, axis] > pivot:
                right -= 1
            if left <= right:
                order[left], order[right] = order[right], order[left]
                for component in range(size):
                    kept = points[left, component]
                    points[left, component] = points[right, component]
                    points[right, component] = kept
                left += 1
                right -= 1
        if middle <= right:
            high = right
        elif middle >= left:
            low = left
        else:
            return


@njit(cache=True, nogil=True, error_model="numpy")
def _pack(first, last, points, order, bounds, leaves, numbers, boxes):
    """Lay the points of every leaf out component by component, and find its box."""
    size = points.shape[1]
    for leaf in range(first, last):
        start = bounds[leaf]
        held = bounds[leaf + 1] - start
        for slot in range(LEAF):
            numbers[leaf, slot] = order[start + slot] if slot < held else NONE
        for component in range(size):
            low, high = FAR, -FAR
            for slot in range(LEAF):
                value = points[start + slot, component] if slot < held else FAR
                leaves[leaf, component, slot] = value
                if slot < held:
                    low, high = min(low, value), max(high, value)
            boxes[leaf, 0, component], boxes[leaf, 1, component] = low, high
