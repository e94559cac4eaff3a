"""Spaces: what a state or an action is made of, field by field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.errors import InvalidInputError

Array = NDArray[np.float64]


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

    @property
    def low(self) -> Array:
        """Lower bounds, shape (size,)."""
        return np.array([field.low for field in self.fields], dtype=np.float64)

    @property
    def high(self) -> Array:
        """Upper bounds, shape (size,)."""
        return np.array([field.high for field in self.fields], dtype=np.float64)

    def clip(self, values: Array) -> Array:
        """`values` of shape (..., size), moved to the nearest point of the box."""
        return np.clip(values, self.low, self.high)

    def check(self, values: ArrayLike, what: str) -> Array:
        """`values` as finite float64 of shape (rows, size).

        Raises InvalidInputError, naming `what`, for another shape or for NaN and infinities.
        """
        return finite_rows(values, self.size, what, ", ".join(self.names))


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
