"""Vectors of eight numbers as portable LLVM IR, for loops that numba would leave scalar.

LLVM lowers them to whatever the processor has; no compiler is needed where the studio runs.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import types

LANES = 8
WORD = ir.IntType(64)
INDEX = ir.IntType(32)
CONTRACT = ("contract",)
"""Lets a product and a sum become one operation where the processor has it."""


class Lanes:
    """Eight numbers of one kind, float32 or float64, and what can be done with them."""

    def __init__(self, builder: Any, kind: Any) -> None:
        self.builder = builder
        self.double = kind == types.float64
        self.scalar = ir.DoubleType() if self.double else ir.FloatType()
        self.integer = ir.IntType(64 if self.double else 32)
        self.vector = ir.VectorType(self.scalar, LANES)
        self.integers = ir.VectorType(self.integer, LANES)

    def constant(self, value: float) -> Any:
        return ir.Constant(self.vector, [value] * LANES)

    def whole(self, value: int) -> Any:
        return ir.Constant(self.integers, [value] * LANES)

    def splat(self, value: Any) -> Any:
        """Eight times the scalar `value`."""
        undefined = ir.Constant(self.vector, ir.Undefined)
        one = self.builder.insert_element(undefined, value, ir.Constant(INDEX, 0))
        lanes = ir.Constant(ir.VectorType(INDEX, LANES), [0] * LANES)
        return self.builder.shuffle_vector(one, undefined, lanes)

    def load(self, base: Any, at: Any) -> Any:
        """The eight numbers from `base[at]` on, aligned or not."""
        place = self.builder.bitcast(self.builder.gep(base, [at]), self.vector.as_pointer())
        return self.builder.load(place, align=self.integer.width // 8)

    def store(self, value: Any, base: Any, at: Any) -> None:
        place = self.builder.bitcast(self.builder.gep(base, [at]), self.vector.as_pointer())
        self.builder.store(value, place, align=self.integer.width // 8)

    def multiply_add(self, one: Any, other: Any, more: Any) -> Any:
        """one * other + more."""
        product = self.builder.fmul(one, other, flags=CONTRACT)
        return self.builder.fadd(product, more, flags=CONTRACT)

    def larger(self, one: Any, other: Any) -> Any:
        """The larger of each two; `other` where `one` is NaN."""
        return self.builder.select(self.builder.fcmp_ordered(">", one, other), one, other)

    def exp(self, value: Any) -> Any:
        """e to the power of `value`, which is at most 0; never quite zero.

        2^k times a Taylor polynomial of the rest, at most log(2) / 2: within 3 units in the last
        place. The logarithm of 2 is split in two as by Cody and Waite (Software Manual for
        the Elementary Functions, 1980).
        """
        builder = self.builder
        mantissa, bias, degree = (52, 1023, 12) if self.double else (23, 127, 7)
        value = self.larger(value, self.constant(-708.0 if self.double else -87.0))
        # Adding 1.5 * 2^mantissa rounds to a whole number, which its lowest bits then hold: here
        # with the bias of the exponent, so that they can be moved in place as they are.
        shift = self.constant(1.5 * 2.0**mantissa + bias)
        shifted = builder.fadd(builder.fmul(value, self.constant(math.log2(math.e))), shift)
        power = builder.fsub(shifted, shift)
        high, low = 0.693145751953125, 1.42860682030941723212e-6
        rest = self.multiply_add(power, self.constant(-high), value)
        rest = self.multiply_add(power, self.constant(-low), rest)
        # Terms in pairs, pairs in pairs and so on (Estrin): the processor can overlap them.
        sums = [self.constant(1.0 / math.factorial(order)) for order in range(degree + 1)]
        argument = rest
        while len(sums) > 1:
            pairs = [
                self.multiply_add(sums[at + 1], argument, sums[at])
                for at in range(0, len(sums) - 1, 2)
            ]
            sums = pairs + sums[2 * len(pairs) :]
            argument = builder.fmul(argument, argument)
        polynomial = sums[0]
        scale = builder.shl(builder.bitcast(shifted, self.integers), self.whole(mantissa))
        return builder.fmul(polynomial, builder.bitcast(scale, self.vector))


def data(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """The pointer to an array's first element."""
    return context.make_array(kind)(context, builder, value=array).data
