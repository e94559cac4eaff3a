"""Searching a tree of boxes: the k nearest points, exactly, one query at a time or many.

Distances are float32 sums over the components in order. Of points equally far the one with the
lower number is nearer. A box is never farther than a point inside it, in float32 too, since
every operation on the way rounds monotonically; so nothing is missed.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from evastudio.learning.kernels.lanes import LANES, LEAF, box_distances, leaf_distances, lowest_bit
from evastudio.learning.kernels.tree import NONE

STACK = 192
"""Nodes that can wait: seven for each of up to 27 levels."""
CHUNK = 64
BEYOND = np.float32(3e38)


@njit(cache=True, nogil=True, inline="always")
def keep_nearest(mask, found, numbers, slot, skip, k, best, chosen):
    """Sort the points of a leaf that `mask` marks into the k nearest so far; the new worst."""
    worst = best[k - 1]
    while mask != 0:
        lane = lowest_bit(mask)
        mask &= mask - 1
        distance, number = found[lane], numbers[slot + lane]
        if number in (skip, NONE):
            continue
        if distance < worst or (distance == worst and number < chosen[k - 1]):
            at = k - 1
            while at > 0 and (
                best[at - 1] > distance or (best[at - 1] == distance and chosen[at - 1] > number)
            ):
                best[at], chosen[at] = best[at - 1], chosen[at - 1]
                at -= 1
            best[at], chosen[at] = distance, number
            worst = best[k - 1]
    return worst


@njit(cache=True, nogil=True)
def search(
    query, q0, size, nodes, children, leaves, numbers, added, added_numbers, k, skip,
    best, chosen, waiting, nearest, found,
):  # fmt: skip
    """The k nearest points to `query[q0:q0 + size]` but for number `skip`.

    Squared distances go to `best`, numbers to `chosen`; the rest is scratch. `added` holds leaves
    of points that came after the tree was built.
    """
    for rank in range(k):
        best[rank], chosen[rank] = BEYOND, NONE
    worst = BEYOND
    for leaf in range(len(added_numbers) // LEAF):
        mask = leaf_distances(query, q0, added, leaf * size * LEAF, size, worst, found)
        worst = keep_nearest(mask, found, added_numbers, leaf * LEAF, skip, k, best, chosen)
    inner = len(children)
    waiting[0], nearest[0] = 0, np.float32(0.0)
    top = 1
    while top > 0:
        top -= 1
        if nearest[top] > worst:
            continue
        node = waiting[top]
        if node >= inner:
            leaf = node - inner
            mask = leaf_distances(query, q0, leaves, leaf * size * LEAF, size, worst, found)
            worst = keep_nearest(mask, found, numbers, leaf * LEAF, skip, k, best, chosen)
            continue
        mask = box_distances(query, q0, nodes, node * 2 * size * LANES, size, worst, found)
        first, child = top, children[node]
        while mask != 0:
            lane = lowest_bit(mask)
            mask &= mask - 1
            distance = found[lane]
            at = top
            while at > first and nearest[at - 1] < distance:
                nearest[at], waiting[at] = nearest[at - 1], waiting[at - 1]
                at -= 1
            nearest[at], waiting[at] = distance, child + lane
            top += 1


@njit(cache=True, nogil=True)
def search_rows(
    queries, first, last, skips, size, nodes, children, leaves, numbers, added, added_numbers, k,
    distances, neighbors,
):  # fmt: skip
    """`search` for the rows from `first` to `last` of flattened `queries`."""
    waiting, nearest = np.empty(STACK, np.int64), np.empty(STACK, np.float32)
    found = np.empty(LEAF, np.float32)
    best, chosen = np.empty(k, np.float32), np.empty(k, np.int32)
    for row in range(first, last):
        search(
            queries, row * size, size, nodes, children, leaves, numbers, added, added_numbers, k,
            skips[row] if len(skips) else np.int32(-1),
            best, chosen, waiting, nearest, found,
        )  # fmt: skip
        for rank in range(k):
            distances[row, rank], neighbors[row, rank] = best[rank], chosen[rank]


@njit(cache=True, nogil=True, parallel=True)
def search_many(
    queries, rows, skips, size, nodes, children, leaves, numbers, added, added_numbers, k,
    distances, neighbors,
):  # fmt: skip
    """`search_rows` for all rows, on all processors: worth it from about 1,000 queries on."""
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        search_rows(
            queries, chunk * CHUNK, min(rows, chunk * CHUNK + CHUNK), skips, size, nodes, children,
            leaves, numbers, added, added_numbers, k, distances, neighbors,
        )  # fmt: skip
