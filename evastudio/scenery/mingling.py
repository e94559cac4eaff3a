"""How people on a grid get along: what a walk through cells comes to, in figures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from evastudio.scenery.strolling import LEFT, RIGHT, STAND, WALK
from evastudio.world.spaces import Array

MINUTE_S = 60.0


def longest_stuck_s(places: NDArray[np.int64], wants_on: NDArray[np.bool_], dt_s: float) -> Array:
    """Longest time from wanting to walk on, and not getting to, until leaving the cell.

    places: the cell each of N stands in at every moment, by number, (moments, ..., N). wants_on:
    who wants to walk on, (moments, ..., N), the last moment not looked at. Shape (..., N), s;
    whatever is done in between counts.
    """
    return _longest(places, lambda so_far, step: (so_far > 0) | wants_on[step]) * dt_s


def longest_still_s(places: NDArray[np.int64], rests: NDArray[np.bool_], dt_s: float) -> Array:
    """Longest time in one cell, not counting moments in which one `rests`; shapes as above."""
    return _longest(places, lambda so_far, step: ~rests[step]) * dt_s


def cells_a_minute(places: NDArray[np.int64], dt_s: float) -> Array:
    """Different cells that each stands in within a minute, the mean over whole minutes, (..., N).

    NaN where there is no whole minute.
    """
    many = round(MINUTE_S / dt_s)
    minutes = len(places) // many
    if minutes == 0:
        return np.full(places.shape[1:], np.nan)
    ordered = np.sort(places[: minutes * many].reshape(minutes, many, *places.shape[1:]), axis=1)
    return np.asarray((1 + (ordered[:, 1:] != ordered[:, :-1]).sum(axis=1)).mean(axis=0))


def dithering(turns: NDArray[np.int64]) -> Array:
    """Share of decisions that take back the turn just made, (..., N).

    turns: 1 to the left, -1 to the right, 0 for none, (moments, ..., N).
    """
    if len(turns) < 2:
        return np.full(turns.shape[1:], np.nan)
    return np.asarray((turns[1:] * turns[:-1] == -1).mean(axis=0))


def mingled(places: NDArray[np.int64], codes: NDArray[np.int64], dt_s: float) -> dict[str, float]:
    """Of a walk through `places`, doing what `codes` say (symbols, of the same shape): the longest
    of anybody, and means over people."""
    turns = (codes == LEFT).astype(np.int64) - (codes == RIGHT)
    return {
        "stuck_s": float(longest_stuck_s(places, codes == WALK, dt_s).max()),
        "still_s": float(longest_still_s(places, codes == STAND, dt_s).max()),
        "cells_per_minute": float(cells_a_minute(places, dt_s).mean()),
        "dithering": float(dithering(turns).mean()),
        "standing": float((codes == STAND).mean()),
        "turning": float((turns != 0).mean()),
    }


def _longest(places: NDArray[np.int64], counts: Callable[[Array, int], Array]) -> Array:
    """Most moments in a row in one cell, of those that `counts`, told how many so far, counts."""
    so_far = longest = np.zeros(places.shape[1:])
    for step in range(len(places) - 1):
        left = places[step + 1] != places[step]
        so_far = np.where(left, 0.0, so_far + counts(so_far, step))
        longest = np.maximum(longest, so_far)
    return longest
