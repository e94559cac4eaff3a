"""A k-NN decision in one call: standardise, search, weigh.

One state and a batch run the same instructions, so the answer to a state is the same in both.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from evastudio.learning.kernels.lanes import LEAF
from evastudio.learning.kernels.search import CHUNK, STACK, search


@njit(cache=True, nogil=True)
def decide_row(
    states, row, offset, scale, largest, nodes, children, leaves, numbers, added, added_numbers,
    actions, k, inverse, floats, integers, out,
):  # fmt: skip
    """The action for `states[row]`, into `out[row]`.

    `inverse` weighs each neighbour by one over its distance; else all count the same. `floats`
    and `integers` are scratch, see `scratch`.
    """
    size = states.shape[1]
    best = floats[LEAF + size : LEAF + size + k]
    nearest = floats[LEAF + size + k :]
    chosen = integers[:k]
    waiting = integers[k:]
    for component in range(size):
        value = (states[row, component] - offset[component]) / scale[component]
        floats[LEAF + component] = np.float32(min(max(value, -largest), largest))
    search(
        floats, LEAF, size, nodes, children, leaves, numbers, added, added_numbers, k, np.int32(-1),
        best, chosen, waiting, nearest, floats,
    )  # fmt: skip
    exact = best[0] == 0.0
    total = 0.0
    for rank in range(k):
        if inverse:
            weight = _weight(best[rank], exact)
            total += weight
    for component in range(actions.shape[1]):
        action = 0.0
        for rank in range(k):
            weight = _weight(best[rank], exact) / total if inverse else 1.0 / k
            action += weight * actions[chosen[rank], component]
        out[row, component] = action


@njit(cache=True, nogil=True)
def _weight(square, exact):
    """One over the distance; where some distance is zero, only those count."""
    if exact:
        return 1.0 if square == 0.0 else 0.0
    return 1.0 / np.sqrt(np.float64(square))


@njit(cache=True, nogil=True)
def decide_rows(
    states, first, last, offset, scale, largest, nodes, children, leaves, numbers, added,
    added_numbers, actions, k, inverse, out,
):  # fmt: skip
    """`decide_row` for the rows from `first` to `last`."""
    floats = np.empty(LEAF + states.shape[1] + k + STACK, np.float32)
    integers = np.empty(k + STACK, np.int64)
    for row in range(first, last):
        decide_row(
            states, row, offset, scale, largest, nodes, children, leaves, numbers, added,
            added_numbers, actions, k, inverse, floats, integers, out,
        )  # fmt: skip


@njit(cache=True, nogil=True, parallel=True)
def decide_many(
    states, offset, scale, largest, nodes, children, leaves, numbers, added, added_numbers, actions,
    k, inverse, out,
):  # fmt: skip
    """`decide_row` for all rows on all processors: worth it from about 1,000 states on."""
    rows = len(states)
    for chunk in prange((rows + CHUNK - 1) // CHUNK):
        decide_rows(
            states, chunk * CHUNK, min(rows, chunk * CHUNK + CHUNK), offset, scale, largest,
            nodes, children, leaves, numbers, added, added_numbers, actions, k, inverse, out,
        )  # fmt: skip


def scratch(size: int, k: int) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """The `floats` and `integers` that `decide_row` needs; one pair for each thread."""
    floats = np.empty(LEAF + size + k + STACK, np.float32)
    return floats, np.empty(k + STACK, np.int64)
