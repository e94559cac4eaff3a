"""Searching for many at once, on all processors; a decision for one does without this module.

Waking the other processors pays from about 1,000 queries on.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from evastudio.learning.kernels.decide import decide_rows
from evastudio.learning.kernels.lanes import LEAF, address, int32_at, int64_at, put_int32
from evastudio.learning.kernels.search import query_place, scratch_for, search
from evastudio.learning.kernels.tree import (
    ADDED,
    ADDED_NUMBERS,
    LEAVES,
    NONE,
    NUMBERS,
    SIZE,
    TREE_LEAVES,
)

CHUNK = 64
"""Queries that one processor takes at a time."""


@njit(cache=True, nogil=True, error_model="numpy")
def search_rows(tree, queries, first, last, k, squares, neighbors):
    """The neighbours (rows, k) of the float32 `queries` (rows, size) from `first` to `last`.

    Squared distances go to `squares` as their bits, numbers to `neighbors`.
    """
    scratch = scratch_for(0, k)
    size = queries.shape[1]
    for row in range(first, last):
        search(tree, address(queries) + 4 * size * row, k, NONE, 0, 0, address(scratch))
        for rank in range(k):
            key = scratch[rank]
            squares[row, rank] = np.int32(key >> 32)
            neighbors[row, rank] = np.int32(key)


@njit(cache=True, nogil=True, parallel=True)
def search_many(tree, queries, k, squares, neighbors):
    """`search_rows` for all rows, on all processors."""
    rows = len(queries)
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        search_rows(tree, queries, first, min(rows, first + CHUNK), k, squares, neighbors)


@njit(cache=True, nogil=True, parallel=True)
def decide_many(table, states, out):
    """`decide` on all processors."""
    if states.shape[1] != int64_at(table, SIZE):
        return False
    rows = len(states)
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        first = chunk * CHUNK
        decide_rows(table, states, first, min(rows, first + CHUNK), out)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def leaf_places(tree, leaf):
    """Where the points and the numbers of a leaf stand; those added come behind the tree's."""
    own = int64_at(tree, TREE_LEAVES)
    points, numbers = int64_at(tree, LEAVES), int64_at(tree, NUMBERS)
    if leaf >= own:
        leaf -= own
        points, numbers = int64_at(tree, ADDED), int64_at(tree, ADDED_NUMBERS)
    return points + leaf * int64_at(tree, SIZE) * LEAF * 4, numbers + leaf * LEAF * 4


@njit(cache=True, nogil=True, error_model="numpy")
def search_leaf(tree, leaf, slot, k, moments, gap, scratch):
    """Search for the neighbours of one point of a leaf; its number, NONE where there is none."""
    points, numbers = leaf_places(tree, leaf)
    number = int32_at(numbers, slot)
    if number != NONE:
        query = query_place(scratch, k)
        for component in range(int64_at(tree, SIZE)):
            put_int32(query, component, int32_at(points, component * LEAF + slot))
        when = address(moments) if len(moments) else 0
        search(tree, query, k, number, when, gap, address(scratch))
    return np.int64(number)


@njit(cache=True, nogil=True, parallel=True)
def search_others(tree, leaves, k, moments, gap, found):
    """For every point the k nearest others that count, to the row of its number in `found`.

    Points of one leaf follow on each other, so that what one search reads the next has at hand.
    """
    for leaf in prange(leaves):
        scratch = scratch_for(int64_at(tree, SIZE), k)
        for slot in range(LEAF):
            number = search_leaf(tree, leaf, slot, k, moments, gap, scratch)
            if number != NONE:
                for rank in range(k):
                    found[number, rank] = np.int32(scratch[rank])


@njit(cache=True, nogil=True, parallel=True)
def deviate_all(tree, leaves, k, moments, gap, actions, found):
    """How far every point's action is from the median of its neighbours', by number to `found`."""
    for leaf in prange(leaves):
        scratch = scratch_for(int64_at(tree, SIZE), k)
        for slot in range(LEAF):
            number = search_leaf(tree, leaf, slot, k, moments, gap, scratch)
            if number != NONE:
                found[number] = deviation(actions, number, k, scratch)


@njit(cache=True, nogil=True, error_model="numpy")
def deviation(actions, number, k, keys):
    """Distance of an action from the vector median of those that `keys` name."""
    median, least = np.int64(np.int32(keys[0])), np.inf
    for rank in range(k):
        candidate, total = np.int64(np.int32(keys[rank])), 0.0
        for other in range(k):
            total += distance(actions, candidate, np.int64(np.int32(keys[other])))
            if total >= least:
                break
        if total < least:
            median, least = candidate, total
    return distance(actions, median, number)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def distance(actions, one, other):
    """The Euclidean distance between two actions."""
    total = 0.0
    for component in range(actions.shape[1]):
        apart = actions[one, component] - actions[other, component]
        total += apart * apart
    return np.sqrt(total)
