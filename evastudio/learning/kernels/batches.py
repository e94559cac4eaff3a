"""Searching for many at once, some at a time; a decision for one does without this module."""

from __future__ import annotations

import numpy as np
from numba import njit

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


@njit(cache=True, nogil=True, error_model="numpy")
def search_others(tree, first, last, k, moments, gap, found):
    """For every point of some leaves the k nearest others that count, by number to `found`.

    Points of one leaf follow on each other, so that what one search reads the next has at hand.
    """
    scratch = scratch_for(int64_at(tree, SIZE), k)
    for leaf in range(first, last):
        for slot in range(LEAF):
            number = search_leaf(tree, leaf, slot, k, moments, gap, scratch)
            if number != NONE:
                for rank in range(k):
                    found[number, rank] = np.int32(scratch[rank])


@njit(cache=True, nogil=True, error_model="numpy")
def deviations(tree, first, last, k, moments, gap, actions, found):
    """As `search_others`, but how far their actions are from the median of the neighbours'."""
    scratch = scratch_for(int64_at(tree, SIZE), k)
    for leaf in range(first, last):
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
