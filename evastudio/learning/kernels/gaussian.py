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


def _bumps(blocks: int) -> Any:
    """An intrinsic for the kernel between a query and `blocks` times eight points.

    bumps(query, q0, points, p0, size, rate, out, o0) writes exp(rate * squared distance) from
    `query[q0:q0 + size]` to `out[o0:]`. `points[p0:]` holds the blocks one after another, each
    component by component, eight numbers each; `rate` is at most 0. All are float32 or all
    float64. More blocks at a time hide how long each operation takes.
    """

    @intrinsic
    def bumps(
        _: Any, query: Any, q0: Any, points: Any, p0: Any, size: Any, rate: Any, out: Any, o0: Any
    ) -> Any:
        kind = out.dtype
        signature = types.void(
            query, types.intp, points, types.intp, types.intp, kind, out, types.intp
        )

        def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            lanes = Lanes(builder, kind)
            asked, held, target = (
                data(context, builder, sig.args[n], arguments[n]) for n in (0, 2, 6)
            )
            q_start, p_start, width, target_start = (arguments[n] for n in (1, 3, 4, 7))
            eight = ir.Constant(WORD, LANES)
            totals = [
                cgutils.alloca_once_value(builder, lanes.constant(0.0)) for _ in range(blocks)
            ]
            with cgutils.for_range(builder, width) as loop:
                component = builder.load(builder.gep(asked, [builder.add(q_start, loop.index)]))
                value = lanes.splat(component)
                at = builder.add(p_start, builder.mul(loop.index, eight))
                for total in totals:
                    apart = builder.fsub(lanes.load(held, at), value)
                    builder.store(lanes.multiply_add(apart, apart, builder.load(total)), total)
                    at = builder.add(at, builder.mul(width, eight))
            factor = lanes.splat(arguments[5])
            for number, total in enumerate(totals):
                bump = lanes.exp(builder.fmul(builder.load(total), factor))
                place = builder.add(target_start, ir.Constant(WORD, LANES * number))
                lanes.store(bump, target, place)
            return context.get_dummy_value()

        return signature, generate

    return bumps


one_block = _bumps(1)
two_blocks = _bumps(2)


@intrinsic
def weigh(_: Any, values: Any, v0: Any, weights: Any, w0: Any, sums: Any, s0: Any) -> Any:
    """Adds values[v0:v0 + 8] * weights[w0:w0 + 8] to sums[s0:s0 + 8], all float64."""
    signature = types.void(values, types.intp, weights, types.intp, sums, types.intp)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, types.float64)
        factors, shares, totals = (
            data(context, builder, sig.args[n], arguments[n]) for n in (0, 2, 4)
        )
        total = lanes.multiply_add(
            lanes.load(factors, arguments[1]),
            lanes.load(shares, arguments[3]),
            lanes.load(totals, arguments[5]),
        )
        lanes.store(total, totals, arguments[5])
        return context.get_dummy_value()

    return signature, generate


@njit(cache=True, nogil=True)
def kernel_row(points, number, blocks, size, rate, out):
    """The kernel between point `number` and all, float32, to `out` (8 * blocks,).

    `points` and `blocks` hold the same points: (count, size), and as `in_blocks` lays them out.
    """
    flat = points.reshape(-1)
    for block in range(len(out) // LANES):
        at = block * size * LANES
        one_block(flat, number * size, blocks, at, size, rate, out, block * LANES)


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
    types.boolean(
        types.Array(types.float64, 1, "C"),
        types.Array(types.float64, 2, "C", readonly=True),
        types.Array(types.float64, 2, "C"),
    ),
    cache=True,
    nogil=True,
)
def decide(machine, states, out):
    """Answers of a packed `machine` to raw `states` (rows, size), to `out` (rows, outputs).

    False, and nothing done, where the shapes do not fit.
    """
    size, outputs, blocks = int(machine[0]), int(machine[1]), int(machine[2])
    rate = machine[3]
    if states.shape[1] != size or out.shape != (len(states), outputs):
        return False
    offset = HEAD
    scale = offset + size
    intercept = scale + size
    points = intercept + outputs
    weights = points + blocks * size * LANES
    scratch = np.empty((2 + outputs) * LANES + size, np.float64)
    sums = scratch[2 * LANES :]
    query = scratch[(2 + outputs) * LANES :]
    for row in range(len(states)):
        for component in range(size):
            value = states[row, component] - machine[offset + component]
            query[component] = value / machine[scale + component]
        sums[: outputs * LANES] = 0.0
        for block in range(0, blocks, 2):
            at = points + block * size * LANES
            both = 2 if block + 1 < blocks else 1
            if both == 2:
                two_blocks(query, 0, machine, at, size, rate, scratch, 0)
            else:
                one_block(query, 0, machine, at, size, rate, scratch, 0)
            for part in range(both):
                at = weights + (block + part) * outputs * LANES
                for output in range(outputs):
                    weigh(scratch, part * LANES, machine, at + output * LANES, sums, output * LANES)
        for output in range(outputs):
            total = 0.0
            for lane in range(LANES):
                total += sums[output * LANES + lane]
            out[row, output] = total + machine[intercept + output]
    return True
