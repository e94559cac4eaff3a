"""Distances from one query to eight points or boxes at a time, as portable vector IR.

numba leaves small inner loops scalar; these intrinsics emit operations on vectors of eight
float32, which LLVM lowers to whatever the processor has. Sums run over the components in order,
each operation is rounded to float32 and none are contracted, so that NumPy gives the same bits.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8
LEAF = 16
"""Points of a leaf of the tree: two vectors."""

_FLOAT, _INT32 = ir.FloatType(), ir.IntType(32)
_VECTOR = ir.VectorType(_FLOAT, LANES)


def _distances(vectors: int, boxes: bool) -> Any:
    """An intrinsic for squared distances to `8 * vectors` points, or to 8 boxes.

    distances(query, q0, data, d0, size, worst, out) looks at `size` components of `query` from
    `q0` on and at `data` from `d0` on, writes the squared distances to `out`, and returns a bit
    mask of those not beyond `worst`. Points lie component by component, 8 * vectors floats each;
    boxes as `size` rows of 8 lower bounds, then as many of upper ones.
    """

    @intrinsic
    def distances(
        _: Any, query: Any, q0: Any, data: Any, d0: Any, size: Any, worst: Any, out: Any
    ) -> Any:
        signature = types.int32(query, types.intp, data, types.intp, types.intp, types.float32, out)

        def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            asked, points, target = (
                context.make_array(sig.args[at])(context, builder, value=arguments[at]).data
                for at in (0, 2, 6)
            )
            q_start, d_start, width = arguments[1], arguments[3], arguments[4]
            word = width.type
            row = ir.Constant(word, LANES * vectors)
            zero = ir.Constant(_VECTOR, [0.0] * LANES)
            sums = [cgutils.alloca_once_value(builder, zero) for _ in range(vectors)]
            to_upper = builder.mul(width, row)
            with cgutils.for_range(builder, width) as loop:
                component = builder.gep(asked, [builder.add(q_start, loop.index)])
                value = _splat(builder, builder.load(component))
                here = builder.add(d_start, builder.mul(loop.index, row))
                for number, total in enumerate(sums):
                    at = builder.add(here, ir.Constant(word, LANES * number))
                    apart = builder.fsub(_load(builder, points, at), value)
                    if boxes:
                        upper = _load(builder, points, builder.add(at, to_upper))
                        apart = _larger(builder, apart, builder.fsub(value, upper))
                        apart = _larger(builder, apart, zero)
                    square = builder.fmul(apart, apart)
                    builder.store(builder.fadd(builder.load(total), square), total)
            bound = _splat(builder, arguments[5])
            mask = ir.Constant(_INT32, 0)
            for number, total in enumerate(sums):
                distance = builder.load(total)
                near = builder.fcmp_ordered("<=", distance, bound)
                bits = builder.zext(builder.bitcast(near, ir.IntType(LANES)), _INT32)
                shifted = builder.shl(bits, ir.Constant(_INT32, LANES * number))
                mask = builder.or_(mask, shifted)
                place = builder.gep(target, [ir.Constant(word, LANES * number)])
                builder.store(distance, builder.bitcast(place, _VECTOR.as_pointer()), align=4)
            return mask

        return signature, generate

    return distances


def _splat(builder: Any, value: Any) -> Any:
    """A vector of eight times `value`."""
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(undefined, value, ir.Constant(_INT32, 0))
    lanes = ir.Constant(ir.VectorType(_INT32, LANES), [0] * LANES)
    return builder.shuffle_vector(one, undefined, lanes)


def _load(builder: Any, base: Any, at: Any) -> Any:
    """Eight floats from `base[at]` on, aligned or not."""
    pointer = builder.bitcast(builder.gep(base, [at]), _VECTOR.as_pointer())
    return builder.load(pointer, align=4)


def _larger(builder: Any, one: Any, other: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", one, other), one, other)


leaf_distances = _distances(LEAF // LANES, boxes=False)
box_distances = _distances(1, boxes=True)


@intrinsic
def lowest_bit(_: Any, mask: Any) -> Any:
    """The number of the lowest bit set in an int32 that is not zero."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int32(types.int32), generate
