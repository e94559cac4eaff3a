"""What every learner asks of the states and actions it is given."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.utils.validation import validate_data

from evastudio.errors import InvalidInputError
from evastudio.world.spaces import Array


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
    return np.asarray(states), actions.reshape(len(states), -1)


def checked_states(learner: Any, states: Any) -> Array:
    """States (rows, n) as finite float64 of the width the learner was fitted with.

    Raises InvalidInputError for another width, NaN or infinities.
    """
    try:
        return np.asarray(validate_data(learner, states, dtype=np.float64, reset=False))
    except ValueError as error:
        raise InvalidInputError(f"These states cannot be answered: {error}") from None


def positive(learner: Any, **values: float) -> None:
    """Raise InvalidInputError for a setting that is not a finite number above zero."""
    for name, value in values.items():
        if not isinstance(value, (int, float, np.number)) or not np.isfinite(value) or value <= 0:
            raise InvalidInputError(
                f"{type(learner).__name__} was given {name}={value!r}; it must be a number above 0."
            )
