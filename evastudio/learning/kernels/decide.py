"""A k-NN decision in one call: standardise, search, weigh.

One state and a batch run the same instructions, so the answer to a state is the same in both.
"""

from __future__ import annotations

import numpy as np
from numba import njit, types

from evastudio.learning.kernels.lanes import (
    address,
    as_float,
    float64_at,
    int64_at,
    put_float32,
    put_float64,
)
from evastudio.learning.kernels.search import query_place, scratch_for, search
from evastudio.learning.kernels.tree import (
    ACTIONS,
    INVERSE,
    LARGEST,
    NONE,
    OFFSET,
    OUTPUTS,
    SCALE,
    SIZE,
    K,
)

_STATES = types.Array(types.float64, 2, "C", readonly=True)
_OUT = types.Array(types.float64, 2, "C")


@njit(cache=True, nogil=True, error_model="numpy")
def decide_rows(table, states, first, last, out):
    """Actions (rows, outputs) for the rows of `states` (rows, size) from `first` to `last`.

    False, and nothing done, where the shapes do not fit.
    """
    size, outputs = int64_at(table, SIZE), int64_at(table, OUTPUTS)
    if states.shape[1] != size or out.shape != (len(states), outputs):
        return False
    k, inverse = int64_at(table, K), int64_at(table, INVERSE) != 0
    offset, scale = int64_at(table, OFFSET), int64_at(table, SCALE)
    actions = int64_at(table, ACTIONS)
    scratch = scratch_for(size, k)
    query = query_place(scratch, k)
    weights = query + 8 * size
    for row in range(first, last):
        for component in range(size):
            value = states[row, component] - float64_at(offset, component)
            value = value / float64_at(scale, component)
            value = min(value, LARGEST) if value > -LARGEST else -LARGEST
            put_float32(query, component, np.float32(value))
        search(table, query, k, NONE, 0, 0, address(scratch))
        total = 0.0
        exact = scratch[0] >> 32 == 0
        for rank in range(k):
            square = np.int32(scratch[rank] >> 32)
            if not inverse:
                weight = 1.0
            elif exact:
                weight = 1.0 if square == 0 else 0.0
            else:
                weight = 1.0 / np.sqrt(np.float64(as_float(square)))
            put_float64(weights, rank, weight)
            total += weight
        for rank in range(k):
            put_float64(weights, rank, float64_at(weights, rank) / total)
        for component in range(outputs):
            action = 0.0
            for rank in range(k):
                number = np.int64(np.int32(scratch[rank]))
                action += float64_at(weights, rank) * float64_at(
                    actions, number * outputs + component
                )
            out[row, component] = action
    return True


@njit(types.boolean(types.int64, _STATES, _OUT), cache=True, nogil=True, error_model="numpy")
def decide(table, states, out):
    """`decide_rows` for all rows."""
    return decide_rows(table, states, 0, len(states), out)
