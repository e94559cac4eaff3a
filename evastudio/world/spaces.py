"""Spaces: what a state or an action is made of, field by field."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.errors import InvalidInputError

Array = NDArray[np.float64]

MOST_SYMBOLS = 256


@dataclass(frozen=True)
class Field:
    """One component of a state or an action."""

    name: str
    unit: str
    low: float
    """Smallest value, may be -inf."""
    high: float
    """Largest value, may be +inf."""


@dataclass(frozen=True)
class Box:
    """A space of real vectors, one `Field` for each component."""

    fields: tuple[Field, ...]

    def __post_init__(self) -> None:
        names = [field.name for field in self.fields]
        if len(set(names)) != len(names):
            raise InvalidInputError(f"The fields {names} repeat a name; each needs its own.")
        for field in self.fields:
            if not field.low < field.high:
                raise InvalidInputError(
                    f"Field {field.name!r} goes from {field.low} to {field.high}; low must be "
                    "below high."
                )

    @property
    def size(self) -> int:
        """Number of components."""
        return len(self.fields)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(field.name for field in self.fields)

    @cached_property
    def low(self) -> Array:
        """Lower bounds, shape (size,), not to be written to."""
        return _sealed([field.low for field in self.fields])

    @cached_property
    def high(self) -> Array:
        """Upper bounds, shape (size,), not to be written to."""
        return _sealed([field.high for field in self.fields])

    def clip(self, values: Array) -> Array:
        """`values` of shape (..., size), moved to the nearest point of the box."""
        return np.clip(values, self.low, self.high)

    def at(self, share: Array) -> Array:
        """The values at `share`, (..., size) in [0, 1), of the way from the low to the high."""
        return np.asarray(self.low + share * (self.high - self.low))

    def change(self, before: Array, after: Array) -> Array:
        """How far values (rows, size) have moved, in ranges, mean over the components; (rows,)."""
        return np.asarray((np.abs(after - before) / (self.high - self.low)).mean(axis=1))

    def check(self, values: ArrayLike, what: str) -> Array:
        """`values` as finite float64 of shape (rows, size).

        Raises InvalidInputError, naming `what`, for another shape or for NaN and infinities.
        """
        return finite_rows(values, self.size, what, ", ".join(self.names))


@dataclass(frozen=True)
class Symbols:
    """A finite set of symbols, of which an action is one: 'stand', 'left', 'right'.

    In arrays a symbol is its code, its place in `names`, so that symbols travel as real actions
    do: float64 of shape (rows, 1). The first is what a character does that is told nothing.
    """

    names: tuple[str, ...]
    moves: tuple[tuple[float, ...], ...] = ()
    """What each is as a vector of real numbers, for learners that learn those; empty where no
    symbol lies between others."""

    def __post_init__(self) -> None:
        if self.moves and (
            len(self.moves) != len(self.names) or len({len(move) for move in self.moves}) != 1
        ):
            raise InvalidInputError(
                f"There are {len(self.moves)} moves for {len(self.names)} symbols; give one for "
                "each, all of one length, or none."
            )
        if not 2 <= len(self.names) <= MOST_SYMBOLS:
            raise InvalidInputError(
                f"There are {len(self.names)} symbols; a character chooses among 2 to "
                f"{MOST_SYMBOLS}."
            )
        if len(set(self.names)) != len(self.names) or not all(
            isinstance(name, str) and name for name in self.names
        ):
            raise InvalidInputError(
                f"The symbols {list(self.names)} repeat a name or leave one empty; each needs "
                "its own."
            )

    @property
    def size(self) -> int:
        """Number of components that an action has in arrays: one, the code."""
        return 1

    @property
    def low(self) -> Array:
        """The smallest code, shape (1,)."""
        return np.zeros(1)

    @property
    def high(self) -> Array:
        """The largest code, shape (1,)."""
        return np.array([len(self.names) - 1.0])

    def clip(self, values: Array) -> Array:
        """`values` of shape (..., 1), moved to the nearest code."""
        return np.clip(np.rint(values), self.low, self.high)

    def at(self, share: Array) -> Array:
        """The codes at `share`, (..., 1) in [0, 1), of the way from the first to the last."""
        return self.clip(np.floor(share * len(self.names)))

    def change(self, before: Array, after: Array) -> Array:
        """1 where another symbol was chosen and 0 where the same, for codes (rows, 1); (rows,)."""
        return np.asarray((before != after).mean(axis=1))

    def check(self, values: ArrayLike, what: str) -> Array:
        """`values` as codes, float64 of shape (rows, 1).

        Raises InvalidInputError, naming `what`, for another shape or for what is no code.
        """
        codes = finite_rows(values, 1, what, "the code of a symbol")
        wrong = codes[codes != self.clip(codes)]
        if wrong.size:
            raise InvalidInputError(
                f"The {what} hold {wrong[0]:g}, the code of no symbol; codes are whole numbers "
                f"from 0 to {len(self.names) - 1} ({', '.join(self.names)})."
            )
        return codes


Space = Box | Symbols
"""What an action is one of."""


def _sealed(numbers: list[float]) -> Array:
    array = np.array(numbers, dtype=np.float64)
    array.setflags(write=False)
    return array


def finite_rows(values: ArrayLike, columns: int, what: str, meaning: str = "") -> Array:
    """`values` as float64 of shape (rows, columns), checked to be finite.

    Raises InvalidInputError for anything that is not a finite table of numbers of that width.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"The {what} are not a table of numbers ({error}).") from None
    if array.ndim != 2 or array.shape[1] != columns:
        names = f" ({meaning})" if meaning else ""
        raise InvalidInputError(
            f"The {what} have shape {array.shape}; expected (rows, {columns}){names}."
        )
    bad = ~np.isfinite(array).all(axis=1)
    if bad.any():
        raise InvalidInputError(
            f"The {what} hold NaN or infinite numbers in {int(bad.sum())} of {len(array)} rows, "
            f"the first is row {int(np.argmax(bad))}; only finite numbers can be used."
        )
    return array
