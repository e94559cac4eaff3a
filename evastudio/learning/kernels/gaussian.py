"""Gaussian kernels, eight points at a time: rows of a kernel matrix, and whole decisions.

Every state is answered by the same instructions in the same order, however many others stand in
the batch, so the answer to one is bit for bit its answer in any batch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from evastudio.learning.kernels.vectors import LANES, WORD, Lanes, data


@intrinsic
def bumps(_: Any, query: Any, q0: Any, points: Any, p0: Any, size: Any, rate: Any, out: Any, o0: Any) -> Any:  # noqa: E501  # fmt: skip
    """exp(rate * squared distance) from `query[q0:q0 + size]` to eight points, to `out[o0:]`.

    `points[p0:]` holds them component by component, eight numbers each; `rate` is at most 0. All
    are float32 or all float64.
    """
    kind = out.dtype
    signature = types.void(query, types.intp, points, types.intp, types.intp, kind, out, types.intp)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, kind)
        asked, held, target = (data(context, builder, sig.args[n], arguments[n]) for n in (0, 2, 6))
        q_start, p_start, width, target_start = (arguments[n] for n in (1, 3, 4, 7))
        total = cgutils.alloca_once_value(builder, lanes.constant(0.0))
        with cgutils.for_range(builder, width) as loop:
            component = builder.load(builder.gep(asked, [builder.add(q_start, loop.index)]))
            at = builder.add(p_start, builder.mul(loop.index, ir.Constant(WORD, LANES)))
            apart = builder.fsub(lanes.load(held, at), lanes.splat(component))
            builder.store(lanes.multiply_add(apart, apart, builder.load(total)), total)
        scaled = builder.fmul(builder.load(total), lanes.splat(arguments[5]))
        lanes.store(lanes.exp(scaled), target, target_start)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def weigh(_: Any, values: Any, weights: Any, w0: Any, sums: Any, s0: Any) -> Any:
    """Adds values[:8] * weights[w0:w0 + 8] to sums[s0:s0 + 8], all float64."""
    signature = types.void(values, weights, types.intp, sums, types.intp)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, types.float64)
        zero = ir.Constant(WORD, 0)
        factors, shares, totals = (
            data(context, builder, sig.args[n], arguments[n]) for n in (0, 1, 3)
        )
        total = lanes.multiply_add(
            lanes.load(factors, zero),
            lanes.load(shares, arguments[2]),
            lanes.load(totals, arguments[4]),
        )
        lanes.store(total, totals, arguments[4])
        return context.get_dummy_value()

    return signature, generate


@njit(cache=True, nogil=True)
def kernel_row(points, number, blocks, size, rate, out):
    """The kernel between point `number` and all, float32, to `out` (8 * blocks,).

    `points` and `blocks` hold the same points: (count, size), and as `in_blocks` lays them out.
    """
    flat = points.reshape(-1)
    for block in range(len(out) // LANES):
        bumps(flat, number * size, blocks, block * size * LANES, size, rate, out, block * LANES)


def in_blocks(points: NDArray[Any]) -> NDArray[Any]:
    """`points` (count, size) as eight at a time, component by component, flattened.

    The last block is filled up with zeros.
    """
    count, size = points.shape
    padded = np.zeros((-(-count // LANES) * LANES, size), points.dtype)
    padded[:count] = points
    return np.ascontiguousarray(
        padded.reshape(len(padded) // LANES, LANES, size).transpose(0, 2, 1)
    ).ravel()


HEAD = 4
"""Numbers at the front of a packed machine: size, outputs, blocks, rate."""


def pack(
    vectors: NDArray[np.float64],
    weights: NDArray[np.float64],
    gamma: float,
    intercept: NDArray[np.float64],
    offset: NDArray[np.float64],
    scale: NDArray[np.float64],
) -> NDArray[np.float64]:
    """All that `decide` needs of a machine in one array, so that calling it costs little.

    vectors (count, size) standardised, weights (count, outputs), intercept (outputs,), offset
    and scale (size,).
    """
    size, outputs = vectors.shape[1], weights.shape[1]
    points = in_blocks(vectors)
    head = [float(size), float(outputs), float(-(-len(vectors) // LANES)), -float(gamma)]
    parts = (np.array(head), offset, scale, intercept, points, in_blocks(weights))
    return np.concatenate(parts).astype(np.float64)


@njit(
    types.void(
        types.Array(types.float64, 1, "C"),
        types.Array(types.float64, 2, "C", readonly=True),
        types.Array(types.float64, 2, "C"),
    ),
    cache=True,
    nogil=True,
)
def decide(machine, states, out):
    """Answers of a packed `machine` to raw `states` (rows, size), to `out` (rows, outputs)."""
    size, outputs, blocks = int(machine[0]), int(machine[1]), int(machine[2])
    rate = machine[3]
    offset = HEAD
    scale = offset + size
    intercept = scale + size
    points = intercept + outputs
    weights = points + blocks * size * LANES
    scratch = np.empty((1 + outputs) * LANES + size, np.float64)
    sums = scratch[LANES:]
    query = scratch[(1 + outputs) * LANES :]
    for row in range(len(states)):
        for component in range(size):
            value = states[row, component] - machine[offset + component]
            query[component] = value / machine[scale + component]
        sums[: outputs * LANES] = 0.0
        for block in range(blocks):
            at = block * size * LANES
            bumps(query, 0, machine, points + at, size, rate, scratch, 0)
            at = weights + block * outputs * LANES
            for output in range(outputs):
                weigh(scratch, machine, at + output * LANES, sums, output * LANES)
        for output in range(outputs):
            total = 0.0
            for lane in range(LANES):
                total += sums[output * LANES + lane]
            out[row, output] = total + machine[intercept + output]
