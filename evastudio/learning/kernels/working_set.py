"""The two passes over all variables that one step of SMO takes, eight variables at a time.

A variable may rise or fall. `slopes` is y - K beta; raising variable i gains slopes[i] - rise[i],
lowering it gains fall[i] - slopes[i]: `rise` and `fall` hold epsilon with the sign that the kink
of |beta| gives it, and infinity where the box ends.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from evastudio.learning.kernels.vectors import INDEX, LANES, WORD, Lanes, data

INFINITY = float("inf")
FLATTEST = 1e-12
"""Least curvature of a step, for points that coincide; as in LIBSVM."""


class _Best:
    """Largest value and its block, apart for each lane."""

    def __init__(self, lanes: Lanes) -> None:
        self.lanes, self.builder = lanes, lanes.builder
        self.numbers = ir.VectorType(INDEX, LANES)
        nowhere = ir.Constant(self.numbers, [-1] * LANES)
        self.value = cgutils.alloca_once_value(self.builder, lanes.constant(-INFINITY))
        self.block = cgutils.alloca_once_value(self.builder, nowhere)

    def offer(self, value: Any, block: Any) -> None:
        builder = self.builder
        best = builder.load(self.value)
        more = builder.fcmp_ordered(">", value, best)
        builder.store(builder.select(more, value, best), self.value)
        undefined = ir.Constant(self.numbers, ir.Undefined)
        one = builder.insert_element(undefined, builder.trunc(block, INDEX), ir.Constant(INDEX, 0))
        here = builder.shuffle_vector(one, undefined, ir.Constant(self.numbers, [0] * LANES))
        builder.store(builder.select(more, here, builder.load(self.block)), self.block)

    def winner(self) -> tuple[Any, Any]:
        """The largest value and its variable: the lowest number of those equally large."""
        builder = self.builder
        values, blocks = builder.load(self.value), builder.load(self.block)
        value, number = None, None
        for lane in range(LANES):
            at = ir.Constant(INDEX, lane)
            one = builder.extract_element(values, at)
            block = builder.sext(builder.extract_element(blocks, at), WORD)
            own = builder.add(builder.mul(block, ir.Constant(WORD, LANES)), ir.Constant(WORD, lane))
            if value is None or number is None:
                value, number = one, own
                continue
            more = builder.fcmp_ordered(">", one, value)
            equal = builder.fcmp_ordered("==", one, value)
            earlier = builder.and_(equal, builder.icmp_signed("<", own, number))
            wins = builder.or_(more, earlier)
            value = builder.select(wins, one, value)
            number = builder.select(wins, own, number)
        return value, number


def _row(lanes: Lanes, base: Any, at: Any) -> Any:
    """Eight kernel values, float32 in memory, as the lanes' kind."""
    value = Lanes(lanes.builder, types.float32).load(base, at)
    return lanes.builder.fpext(value, lanes.vector) if lanes.double else value


@intrinsic
def advance(_: Any, rows: Any, one: Any, two: Any, width: Any, step: Any, slopes: Any, rise: Any) -> Any:  # noqa: E501  # fmt: skip
    """Raise a variable by `step`, lower another by it; then who gains most by rising.

    `one` and `two` are where their kernel rows of `width` values begin in `rows`; `slopes` is
    brought up to date. Returns (gain + epsilon's part, variable).
    """
    kind = slopes.dtype
    signature = types.Tuple((kind, types.intp))(
        rows, types.intp, types.intp, types.intp, kind, slopes, rise
    )

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, kind)
        kernel, slope, barrier = (
            data(context, builder, sig.args[n], arguments[n]) for n in (0, 5, 6)
        )
        factor = lanes.splat(builder.fneg(arguments[4]))
        best = _Best(lanes)
        with cgutils.for_range(
            builder, builder.sdiv(arguments[3], ir.Constant(WORD, LANES))
        ) as loop:
            at = builder.mul(loop.index, ir.Constant(WORD, LANES))
            change = builder.fsub(
                _row(lanes, kernel, builder.add(arguments[1], at)),
                _row(lanes, kernel, builder.add(arguments[2], at)),
            )
            new = lanes.multiply_add(change, factor, lanes.load(slope, at))
            lanes.store(new, slope, at)
            best.offer(builder.fsub(new, lanes.load(barrier, at)), loop.index)
        return context.make_tuple(builder, sig.return_type, best.winner())

    return signature, generate


@intrinsic
def choose(_: Any, rows: Any, one: Any, width: Any, top: Any, slopes: Any, fall: Any) -> Any:
    """Whom to lower while the variable whose kernel row begins at `one` rises, gaining `top`.

    The partner with the largest decrease of the objective by a quadratic model (Fan, Chen and
    Lin, Working Set Selection Using Second Order Information, JMLR 6, 2005, eq. 10). Returns
    (largest violation of optimality, partner).
    """
    kind = slopes.dtype
    signature = types.Tuple((kind, types.intp))(rows, types.intp, types.intp, kind, slopes, fall)

    def generate(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = Lanes(builder, kind)
        kernel, slope, barrier = (
            data(context, builder, sig.args[n], arguments[n]) for n in (0, 4, 5)
        )
        most = lanes.splat(arguments[3])
        best = _Best(lanes)
        widest = cgutils.alloca_once_value(builder, lanes.constant(-INFINITY))
        with cgutils.for_range(
            builder, builder.sdiv(arguments[2], ir.Constant(WORD, LANES))
        ) as loop:
            at = builder.mul(loop.index, ir.Constant(WORD, LANES))
            low = builder.fsub(lanes.load(slope, at), lanes.load(barrier, at))
            gap = builder.fsub(most, low)
            builder.store(lanes.larger(gap, builder.load(widest)), widest)
            near = _row(lanes, kernel, builder.add(arguments[1], at))
            curvature = lanes.multiply_add(near, lanes.constant(-2.0), lanes.constant(2.0))
            curvature = lanes.larger(curvature, lanes.constant(FLATTEST))
            positive = lanes.larger(gap, lanes.constant(0.0))
            gain = builder.fdiv(builder.fmul(positive, positive), curvature)
            best.offer(gain, loop.index)
        gaps = builder.load(widest)
        violation = builder.extract_element(gaps, ir.Constant(INDEX, 0))
        for lane in range(1, LANES):
            gap = builder.extract_element(gaps, ir.Constant(INDEX, lane))
            more = builder.fcmp_ordered(">", gap, violation)
            violation = builder.select(more, gap, violation)
        _value, partner = best.winner()
        return context.make_tuple(builder, sig.return_type, (violation, partner))

    return signature, generate
