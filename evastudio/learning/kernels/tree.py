"""A tree of boxes over points, eight children wide, built once and never changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from evastudio.learning.kernels.lanes import LANES, LEAF

Floats = NDArray[np.float32]
FAR = np.float32(1e18)
"""Coordinate of slots that hold no point: farther than any that does."""
NONE = np.int32(2**31 - 1)
"""Number of no point."""


@dataclass(frozen=True)
class Tree:
    """A balanced k-d tree whose nodes are laid out for `kernels.search`.

    Binary splits at the median of the widest component until at most 16 points are left; three
    binary levels then make one level of eight children.
    """

    nodes: Floats
    """Boxes of every node's children: (nodes, 2, size, 8) flattened."""
    children: NDArray[np.int64]
    """First child of every node, shape (nodes,); from the number of nodes on they are leaves."""
    leaves: Floats
    """Points of every leaf, component by component: (leaves, size, 16) flattened."""
    numbers: NDArray[np.int32]
    """Number of the point in each slot of the leaves, NONE where there is none."""
    size: int
    """Components of a point."""


def build_tree(points: Floats) -> Tree:
    """A tree over `points` (n, size), n at least 1."""
    points = np.ascontiguousarray(points, dtype=np.float32)
    count, size = points.shape
    depth = 0
    while -(-count // (1 << depth)) > LEAF:
        depth += 1
    order = np.arange(count, dtype=np.int32)
    boxes = np.empty(((1 << (depth + 1)) - 1, 2, size), np.float32)
    bounds = _split(points, order, depth, boxes)
    leaves = np.empty((1 << depth) * size * LEAF, np.float32)
    numbers = np.empty((1 << depth) * LEAF, np.int32)
    _pack(points, order, bounds, leaves, numbers)
    height = max(1, -(-depth // 3))
    parts, children, first_child = [], [], 0
    for level in range(height):
        below = depth - 3 * (height - 1 - level)
        first = (1 << below) - 1
        width = 1 << (depth - 3 * (height - 1)) if level == 0 else LANES
        parents = (1 << below) // width
        wide = np.full((parents, 2, size, LANES), FAR, np.float32)
        found = boxes[first : first + (1 << below)].reshape(parents, width, 2, size)
        wide[:, :, :, :width] = found.transpose(0, 2, 3, 1)
        parts.append(wide.ravel())
        first_child += parents
        children.append(first_child + width * np.arange(parents))
    return Tree(np.concatenate(parts), np.concatenate(children), leaves, numbers, size)


@njit(cache=True, nogil=True, parallel=True)
def _split(points, order, depth, boxes):
    """Order the points by binary splits and fill in every node's box; bounds of the leaves."""
    count, size = points.shape
    bounds = np.zeros((1 << depth) + 1, np.int64)
    bounds[1] = count
    for level in range(depth + 1):
        nodes = 1 << level
        inner = np.zeros(2 * nodes + 1, np.int64)
        inner[2 * nodes] = count
        for node in prange(nodes):
            start, stop = bounds[node], bounds[node + 1]
            at = nodes - 1 + node
            axis, widest = 0, np.float32(-1.0)
            for component in range(size):
                low, high = FAR, -FAR
                for place in range(start, stop):
                    value = points[order[place], component]
                    low, high = min(low, value), max(high, value)
                boxes[at, 0, component], boxes[at, 1, component] = low, high
                if high - low > widest:
                    axis, widest = component, high - low
            middle = (start + stop + 1) >> 1
            if level < depth:
                _select(points, order, start, stop, middle, axis)
            inner[2 * node], inner[2 * node + 1] = start, middle
        if level < depth:
            bounds[: 2 * nodes + 1] = inner
    return bounds


@njit(cache=True, nogil=True)
def _select(points, order, start, stop, middle, axis):
    """Reorder order[start:stop] so that none before `middle` lies above one after it (Hoare)."""
    low, high = start, stop - 1
    while low < high:
        one = points[order[low], axis]
        two = points[order[(low + high) >> 1], axis]
        three = points[order[high], axis]
        pivot = max(min(one, two), min(max(one, two), three))
        left, right = low, high
        while left <= right:
            while points[order[left], axis] < pivot:
                left += 1
            while points[order[right], axis] > pivot:
                right -= 1
            if left <= right:
                order[left], order[right] = order[right], order[left]
                left += 1
                right -= 1
        if middle <= right:
            high = right
        elif middle >= left:
            low = left
        else:
            return


@njit(cache=True, nogil=True, parallel=True)
def _pack(points, order, bounds, leaves, numbers):
    """Lay the points of every leaf out component by component."""
    size = points.shape[1]
    for leaf in prange(len(bounds) - 1):
        start = bounds[leaf]
        held = bounds[leaf + 1] - start
        for slot in range(LEAF):
            number = order[start + slot] if slot < held else NONE
            numbers[leaf * LEAF + slot] = number
            for component in range(size):
                value = points[number, component] if slot < held else FAR
                leaves[(leaf * size + component) * LEAF + slot] = value
