"""Searching a tree of boxes: the k nearest points, exactly, one query at a time or many.

Distances are float32 sums over the components in order. Of points equally far the one with the
lower number is nearer: a key holds the bits of the squared distance above those of the number, so
that keys sort as neighbours do. A box is never farther than a point inside it, in float32 too,
since every operation on the way rounds monotonically; so nothing is missed.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from evastudio.learning.kernels.lanes import (
    LEAF,
    address,
    int32_at,
    int64_at,
    keep,
    leaf_distances,
    lowest_bit,
    near_children,
    put_int32,
    put_int64,
)
from evastudio.learning.kernels.tree import (
    ADDED,
    ADDED_LEAVES,
    ADDED_NUMBERS,
    CHILDREN,
    INNER,
    LEAVES,
    NODES,
    NONE,
    NUMBERS,
    SIZE,
)
from evastudio.learning.kernels.vectors import LANES

STACK = 200
"""Nodes that can wait: seven for each of up to 27 levels, and eight that are being written."""
BEYOND = np.int32(0x7F7FFFFF)
"""The bits of the largest float32."""
EMPTY = (int(BEYOND) << 32) | int(NONE)


@njit(cache=True, nogil=True, error_model="numpy")
def scratch_for(size, k):
    """Memory for one search after another: see `search`, then a query of `size` and k weights."""
    return np.empty((k + LANES - 1) // LANES * LANES + LEAF // 2 + STACK + size + k, np.int64)


@njit(cache=True, nogil=True, error_model="numpy")
def query_place(scratch, k):
    """Where scratch memory has room for a query."""
    return address(scratch) + 8 * ((k + LANES - 1) // LANES * LANES + LEAF // 2 + STACK)


@njit(cache=True, nogil=True, inline="always")
def look(query, leaf, numbers, size, worst, k, own, moments, gap, keys, found):
    """Sort the points of a leaf into the k nearest so far; the new worst."""
    mask = leaf_distances(query, leaf, size, worst, found)
    while mask != 0:
        lane = lowest_bit(mask)
        mask &= mask - 1
        number = int32_at(numbers, lane)
        if number == own:
            continue
        if moments != 0 and abs(int64_at(moments, number) - int64_at(moments, own)) <= gap:
            continue
        keep(keys, (k + LANES - 1) // LANES, (np.int64(int32_at(found, lane)) << 32) | number)
        worst = np.int32(int64_at(keys, k - 1) >> 32)
    return worst


@njit(cache=True, nogil=True, error_model="numpy")
def search(tree, query, k, own, moments, gap, keys):
    """The k nearest points to the float32 at `query`: their keys, ascending, at `keys`.

    `tree` is the address of a table, see `tree.table`. Point number `own` does not count, nor,
    where `moments` is the address of everybody's, do those within `gap` of its own. Behind the
    keys there is scratch memory.
    """
    blocks = (k + LANES - 1) // LANES
    found = keys + 8 * LANES * blocks
    nearest = found + 4 * LEAF
    waiting = nearest + 4 * STACK
    size, inner = int64_at(tree, SIZE), int64_at(tree, INNER)
    nodes, children = int64_at(tree, NODES), int64_at(tree, CHILDREN)
    leaves, numbers = int64_at(tree, LEAVES), int64_at(tree, NUMBERS)
    for rank in range(LANES * blocks):
        put_int64(keys, rank, EMPTY)
    worst = BEYOND
    for leaf in range(int64_at(tree, ADDED_LEAVES)):
        worst = look(
            query, int64_at(tree, ADDED) + leaf * size * LEAF * 4,
            int64_at(tree, ADDED_NUMBERS) + leaf * LEAF * 4,
            size, worst, k, own, moments, gap, keys, found,
        )  # fmt: skip
    put_int32(nearest, 0, np.int32(0))
    put_int32(waiting, 0, np.int32(0))
    top = 1
    while top > 0:
        top -= 1
        if int32_at(nearest, top) > (worst | 7):
            continue
        node = np.int64(int32_at(waiting, top))
        first = int64_at(children, node)
        boxes = nodes + node * size * 2 * LANES * 4
        here = top + near_children(
            query, boxes, size, worst, first, nearest + 4 * top, waiting + 4 * top
        )
        if first < inner:
            top = here
            continue
        while here > top:  # leaves: look at them at once, the nearest first
            here -= 1
            if int32_at(nearest, here) > (worst | 7):
                break
            leaf = int32_at(waiting, here) - inner
            worst = look(
                query, leaves + leaf * size * LEAF * 4, numbers + leaf * LEAF * 4,
                size, worst, k, own, moments, gap, keys, found,
            )  # fmt: skip
