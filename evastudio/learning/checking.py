"""What every learner asks of the states and actions it is given."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.utils import assert_all_finite
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import column_or_1d, validate_data

from evastudio.errors import InvalidInputError
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array, finite_rows

LARGEST = 1e30
"""Squares of numbers beyond this, and what is made of them, would leave the range of floats."""


def checked_pairs(learner: Any, states: Any, actions: Any) -> tuple[Array, Array]:
    """States (pairs, n) and actions (pairs, m) as finite float64; m = 1 for a flat list.

    Remembers on the learner how many components states have and whether actions were flat.
    Raises InvalidInputError for no pairs, NaN, infinities, or shapes that do not fit.
    """
    if actions is None:
        raise InvalidInputError(
            f"{type(learner).__name__} requires y to be passed, but the target y is None: "
            "give an action for every state."
        )
    try:
        states, actions = validate_data(
            learner, states, actions, dtype=np.float64, multi_output=True, y_numeric=True
        )
    except ValueError as error:
        raise InvalidInputError(f"These pairs cannot be learned from: {error}") from None
    actions = np.asarray(actions, dtype=np.float64)
    learner.flat_ = actions.ndim == 1
    return bearable(states, "states"), bearable(actions.reshape(len(states), -1), "actions")


def checked_states(learner: Any, states: Any) -> Array:
    """States (rows, n) as finite float64 of the width the learner was fitted with.

    Raises InvalidInputError for another width, NaN or infinities.
    """
    try:
        checked = validate_data(learner, states, dtype=np.float64, reset=False)
    except ValueError as error:
        raise InvalidInputError(f"These states cannot be answered: {error}") from None
    return bearable(checked, "states")


def bearable(values: Array, what: str) -> Array:
    """`values` if none is beyond `LARGEST`. Raises InvalidInputError, naming `what`."""
    largest = np.abs(values).max(initial=0.0)
    if largest > LARGEST:
        raise InvalidInputError(
            f"The {what} hold numbers as large as {largest:.3g}; up to {LARGEST:g} can be learned "
            "from. Give them in another unit."
        )
    return np.asarray(values)


def checked_actions(actions: Any, rows: int, columns: int) -> Array:
    """Actions as finite float64 (rows, columns); a flat list where there is one column.

    Raises InvalidInputError for anything else.
    """
    array = np.asarray(actions, dtype=np.float64)
    if array.ndim == 1 and columns == 1:
        array = array[:, None]
    checked = finite_rows(array, columns, "actions")
    if len(checked) != rows:
        raise InvalidInputError(
            f"There are {rows} states and {len(checked)} actions; every state needs one action."
        )
    return bearable(checked, "actions")


def checked_targets(learner: Any, symbols: Any) -> AnyArray:
    """Symbols (pairs,) to learn. Raises InvalidInputError for what cannot be symbols."""
    if symbols is None:
        raise InvalidInputError(
            f"{type(learner).__name__} requires y to be passed, but the target y is None: "
            "give a symbol for every state."
        )
    try:
        flat = column_or_1d(symbols, warn=True)
        assert_all_finite(flat, input_name="y")
        check_classification_targets(flat)
    except ValueError as error:
        raise InvalidInputError(f"These symbols cannot be learned: {error}") from None
    return np.asarray(flat)


def checked_symbols(symbols: AnyArray, known: AnyArray) -> NDArray[np.int64]:
    """The places of `symbols` (pairs,) among `known`, which are sorted.

    Raises InvalidInputError for a symbol that is not among them.
    """
    unknown = ~np.isin(symbols, known)
    if unknown.any():
        raise InvalidInputError(
            f"The symbol {str(symbols[unknown][0])!r} was not among those fitted "
            f"({', '.join(map(str, known))}); fit anew to add one."
        )
    return np.asarray(np.searchsorted(known, symbols), dtype=np.int64)


def checked_indices(indices: ArrayLike, count: int) -> NDArray[np.int64]:
    """Distinct indices from 0 to `count`, sorted. Raises InvalidInputError for others."""
    array = np.unique(np.asarray(indices))
    if array.ndim != 1 or not (array.size == 0 or np.issubdtype(array.dtype, np.integer)):
        raise InvalidInputError(f"{indices!r} are no indices of pairs; give whole numbers.")
    if array.size and not (array[0] >= 0 and array[-1] < count):
        raise InvalidInputError(
            f"The indices go from {array[0]} to {array[-1]}, but there are {count} pairs, "
            f"numbered from 0 to {count - 1}."
        )
    return array.astype(np.int64)


def positive(learner: Any, **values: float) -> None:
    """Raise InvalidInputError for a setting that is not a finite number above zero."""
    for name, value in values.items():
        if not isinstance(value, (int, float, np.number)) or not np.isfinite(value) or value <= 0:
            raise InvalidInputError(
                f"{type(learner).__name__} was given {name}={value!r}; it must be a number above 0."
            )
