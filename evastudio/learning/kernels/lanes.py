"""Distances from one query to eight points or boxes at a time, as portable vector IR.

numba leaves small inner loops scalar and sorts by branches that no processor can foresee; these
intrinsics emit operations on vectors of eight, which LLVM lowers to whatever the processor has.
Sums run over the components in order, each operation is rounded to float32 and none are
contracted, so that NumPy gives the same bits.

Memory is given by its address, an int64, so that a whole tree is one argument; whoever calls keeps
the arrays. Squared distances are also compared as the int32 of the same bits, which have the same
order.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from evastudio.learning.kernels.vectors import INDEX, LANES, WORD, Lanes, data

LEAF = 16
"""Points of a leaf of the tree: two vectors."""
_KEYS = ir.VectorType(WORD, LANES)
_FIRST = -(2**63)


def _pointer(builder: Any, address: Any, kind: Any) -> Any:
    return builder.inttoptr(address, kind.as_pointer())


def _reader(kind: Any, stored: Any) -> Any:
    @intrinsic
    def read(_: Any, address: Any, at: Any) -> Any:
        """The number of one kind that stands `at` places behind `address`."""

        def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            return builder.load(
                builder.gep(_pointer(builder, arguments[0], stored), [arguments[1]])
            )

        return kind(types.int64, types.int64), generate

    return read


def _writer(kind: Any, stored: Any) -> Any:
    @intrinsic
    def write(_: Any, address: Any, at: Any, value: Any) -> Any:
        """Puts a number of one kind `at` places behind `address`."""

        def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
            base = _pointer(builder, arguments[0], stored)
            builder.store(arguments[2], builder.gep(base, [arguments[1]]))
            return context.get_dummy_value()

        return types.void(types.int64, types.int64, kind), generate

    return write


int32_at, int64_at = _reader(types.int32, INDEX), _reader(types.int64, WORD)
float64_at = _reader(types.float64, ir.DoubleType())
put_int32, put_float32 = _writer(types.int32, INDEX), _writer(types.float32, ir.FloatType())
put_int64, put_float64 = _writer(types.int64, WORD), _writer(types.float64, ir.DoubleType())


@intrinsic
def address(_: Any, array: Any) -> Any:
    """Where an array begins. It is freed when no longer used by name: use it after its address."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.ptrtoint(data(context, builder, sig.args[0], arguments[0]), WORD)

    return types.int64(array), generate


@intrinsic
def as_float(_: Any, bits: Any) -> Any:
    """The float32 of the bits of an int32."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.FloatType())

    return types.float32(types.int32), generate


@intrinsic
def lowest_bit(_: Any, mask: Any) -> Any:
    """The number of the lowest bit set in an int32 that is not zero."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int32(types.int32), generate


@intrinsic
def leaf_distances(_: Any, query: Any, leaf: Any, size: Any, worst: Any, found: Any) -> Any:
    """Writes 16 squared distances to `found`; a bit mask of those not beyond `worst`.

    `query` has `size` components; a leaf lies component by component, 16 floats each.
    """

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, types.float32)
        asked, points, target = (_pointer(builder, arguments[n], lanes.scalar) for n in (0, 1, 4))
        sums = [
            cgutils.alloca_once_value(builder, lanes.constant(0.0)) for _ in range(LEAF // LANES)
        ]
        with cgutils.for_range(builder, arguments[2]) as loop:
            value = lanes.splat(builder.load(builder.gep(asked, [loop.index])))
            at = builder.mul(loop.index, ir.Constant(WORD, LEAF))
            for total in sums:
                apart = builder.fsub(lanes.load(points, at), value)
                square = builder.fmul(apart, apart)
                builder.store(builder.fadd(builder.load(total), square), total)
                at = builder.add(at, ir.Constant(WORD, LANES))
        bound = lanes.splat(builder.bitcast(arguments[3], lanes.scalar))
        mask = ir.Constant(INDEX, 0)
        for number, total in enumerate(sums):
            distances = builder.load(total)
            lanes.store(distances, target, ir.Constant(WORD, LANES * number))
            near = builder.fcmp_ordered("<=", distances, bound)
            bits = builder.zext(builder.bitcast(near, ir.IntType(LANES)), INDEX)
            mask = builder.or_(mask, builder.shl(bits, ir.Constant(INDEX, LANES * number)))
        return mask

    signature = types.int32(types.int64, types.int64, types.int64, types.int32, types.int64)
    return signature, generate


@intrinsic
def near_children(
    _: Any, query: Any, boxes: Any, size: Any, worst: Any, first: Any, keys: Any, nodes: Any
) -> Any:
    """Writes those of eight boxes that are not beyond `worst`, the farthest first; how many.

    `boxes` are `size` rows of 8 lower bounds, then as many of upper ones. A key is the squared
    distance with the last three bits replaced by the number of the box; its node is that number
    behind `first`. Eight of each are always written, those beyond `worst` last.
    """

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, types.float32)
        asked, bounds = (_pointer(builder, arguments[n], lanes.scalar) for n in (0, 1))
        zero = lanes.constant(0.0)
        total = cgutils.alloca_once_value(builder, zero)
        row = ir.Constant(WORD, LANES)
        to_upper = builder.mul(arguments[2], row)
        with cgutils.for_range(builder, arguments[2]) as loop:
            value = lanes.splat(builder.load(builder.gep(asked, [loop.index])))
            at = builder.mul(loop.index, row)
            below = builder.fsub(lanes.load(bounds, at), value)
            above = builder.fsub(value, lanes.load(bounds, builder.add(at, to_upper)))
            apart = lanes.larger(lanes.larger(below, above), zero)
            square = builder.fmul(apart, apart)
            builder.store(builder.fadd(builder.load(total), square), total)
        distances = builder.load(total)
        bound = lanes.splat(builder.bitcast(arguments[3], lanes.scalar))
        near = builder.fcmp_ordered("<=", distances, bound)
        own = ir.Constant(lanes.integers, list(range(LANES)))
        high = builder.and_(builder.bitcast(distances, lanes.integers), lanes.whole(-LANES))
        key = builder.select(near, builder.or_(high, own), lanes.whole(-1))
        key = _descending(builder, key)
        start = builder.trunc(arguments[4], INDEX)
        start = builder.bitcast(lanes.splat(builder.bitcast(start, lanes.scalar)), lanes.integers)
        node = builder.add(start, builder.and_(key, lanes.whole(LANES - 1)))
        for value, target in ((key, arguments[5]), (node, arguments[6])):
            builder.store(value, _pointer(builder, target, lanes.integers), align=4)
        bits = builder.bitcast(near, ir.IntType(LANES))
        return builder.zext(builder.ctpop(bits), WORD)

    word = types.int64
    return word(word, word, word, types.int32, word, word, word), generate


def _descending(builder: Any, values: Any) -> Any:
    """The eight integers sorted, the largest first, by a bitonic network (Batcher, 1968)."""
    undefined = ir.Constant(values.type, ir.Undefined)
    for size, apart in ((2, 1), (4, 2), (4, 1), (8, 4), (8, 2), (8, 1)):
        partners = ir.Constant(ir.VectorType(INDEX, LANES), [lane ^ apart for lane in range(LANES)])
        others = builder.shuffle_vector(values, undefined, partners)
        larger = builder.icmp_signed(">", values, others)
        high = builder.select(larger, values, others)
        low = builder.select(larger, others, values)
        chosen = [
            lane if ((lane & size) == 0) == ((lane & apart) == 0) else lane + LANES
            for lane in range(LANES)
        ]
        values = builder.shuffle_vector(high, low, ir.Constant(ir.VectorType(INDEX, LANES), chosen))
    return values


@intrinsic
def keep(_: Any, keys: Any, blocks: Any, key: Any) -> Any:
    """Sorts `key` into `blocks` times eight int64 in ascending order; the last one falls out."""

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        base = _pointer(builder, arguments[0], WORD)
        lanes = Lanes(builder, types.float64)
        value = builder.bitcast(arguments[2], lanes.scalar)
        new = builder.bitcast(lanes.splat(value), _KEYS)
        lowest = ir.Constant(_KEYS, [_FIRST] * LANES)
        before = cgutils.alloca_once_value(builder, lowest)
        shift = ir.Constant(ir.VectorType(INDEX, LANES), [LANES - 1, *range(LANES, 2 * LANES - 1)])
        with cgutils.for_range(builder, arguments[1]) as loop:
            at = builder.mul(loop.index, ir.Constant(WORD, LANES))
            place = builder.bitcast(builder.gep(base, [at]), _KEYS.as_pointer())
            held = builder.load(place, align=8)
            moved = builder.shuffle_vector(builder.load(before), held, shift)
            builder.store(held, before)
            moved = builder.select(builder.icmp_signed(">", moved, new), moved, new)
            kept = builder.select(builder.icmp_signed("<", held, moved), held, moved)
            builder.store(kept, place, align=8)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate
