"""Flights through asteroid fields, a few worlds in step: the arithmetic of `scenes/asteroids.py`
between the points where NumPy computes sines, cosines and exponentials.

Every operation is the scene's own, in its order and none contracted, so that both give the same
bits; a test holds them together. `worlds` counts the worlds of the batch, `alive` (first ones of)
says which of them go on: rows of what is perceived belong to those.
"""

from __future__ import annotations

import numpy as np
from numba import njit, types

from evastudio.world.kernels.rocks import NUMBERS, TABLE, VECTORS, nearest_to, worst_to

(
    STEP, TURN, HEADING, RADIUS, REACH, SIGHT, MARGIN, HALF_WIDTH, LENGTH, DT, LIMIT,
    AHEAD, ASIDE, SLAB, NUMBERS_OF,
) = range(15)  # fmt: skip
"""What stands where among the numbers of a scene."""
CROSSED, HIT, LEFT, LATE = 1, 2, 3, 4
"""Outcomes."""
_FIELD = (
    types.Array(types.float64, 3, "C", readonly=True),
    types.Array(types.int64, 2, "C", readonly=True),
    types.Array(types.float64, 1, "C", readonly=True),
)
"""Rocks, cells and half widths."""
_ALIVE = types.Array(types.int64, 1, "C")
_NUMBERS = types.Array(types.float64, 1, "C", readonly=True)


@njit(
    types.void(
        *_FIELD,
        types.int64,
        _NUMBERS,
        _ALIVE,
        types.int64,
        TABLE,
        TABLE,
        TABLE,
        VECTORS,
        TABLE,
        TABLE,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def look(
    rocks, cells, halves, rows, numbers, alive, count, position, cosines, sines, threats, aside,
    weights,
):  # fmt: skip
    """What endangers each ship, to `threats` (worlds, 8, 3), and how far aside that is.

    `weights` gets the logarithms of their weights, infinitely little where there is no threat.
    """
    forward, left, up = np.empty(3), np.empty(3), np.empty(3)
    menaces = np.empty(weights.shape[1])
    for row in range(count):
        world = alive[row]
        cos_t, cos_p = cosines[world, 0], cosines[world, 1]
        sin_t, sin_p = sines[world, 0], sines[world, 1]
        forward[0], forward[1], forward[2] = cos_p * cos_t, cos_p * sin_t, sin_p
        left[0], left[1], left[2] = -sin_t, cos_t, 0.0
        up[0], up[1], up[2] = -sin_p * cos_t, -sin_p * sin_t, cos_p
        menaces[:] = numbers[SIGHT]
        worst_to(
            rocks, cells, halves[world], world, position[world], forward, left, up,
            numbers[RADIUS], numbers[SIGHT], numbers[SLAB], rows, threats[row], menaces,
        )  # fmt: skip
        for rank in range(len(menaces)):
            if not menaces[rank] < numbers[SIGHT]:
                threats[row, rank, 1] = threats[row, rank, 2] = aside[row, rank] = 0.0
                weights[row, rank] = -np.inf
                continue
            left_of, above = threats[row, rank, 1], threats[row, rank, 2]
            apart = np.sqrt(left_of * left_of + above * above)
            aside[row, rank] = apart
            ahead = max(threats[row, rank, 0] - numbers[RADIUS], 0.0) / numbers[AHEAD]
            clear = max(apart - numbers[REACH], 0.0) / numbers[ASIDE]
            weights[row, rank] = -ahead - clear


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def within(value, low, high):
    """`value`, moved to the nearest number from `low` to `high`."""
    value = value if value > low else low
    return value if value < high else high


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def course_beside(heading, aside, width):
    """One component of the heading, beside the course to hold."""
    wander = within((abs(aside) / width - 0.4) / 0.6, 0.0, 1.0)
    return heading + np.sign(aside) * wander * 0.6


@njit(
    types.void(
        _NUMBERS, _FIELD[2], _ALIVE, types.int64, TABLE, TABLE, VECTORS, TABLE, TABLE,
        _NUMBERS, _NUMBERS, TABLE, VECTORS,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def perceive(
    numbers, halves, alive, count, position, heading, threats, aside, weights, lows, highs,
    states, frames,
):  # fmt: skip
    """The canonical states of what `look` found, and their frames, to `states` and `frames`."""
    for row in range(count):
        world = alive[row]
        width = halves[world] - numbers[MARGIN]
        course_0 = course_beside(heading[world, 0], position[world, 1], width)
        course_1 = course_beside(heading[world, 1], position[world, 2], width)
        first_0 = first_1 = pressure_0 = pressure_1 = 0.0
        for rank in range(weights.shape[1]):
            share = weights[row, rank] / max(aside[row, rank], 1e-9)
            push_0, push_1 = share * threats[row, rank, 1], share * threats[row, rank, 2]
            if rank == 0:
                first_0, first_1 = push_0, push_1
                pressure_0, pressure_1 = push_0, push_1
            else:
                pressure_0 += push_0
                pressure_1 += push_1
        strength = np.sqrt(pressure_0 * pressure_0 + pressure_1 * pressure_1)
        error = np.sqrt(course_0 * course_0 + course_1 * course_1)
        along_0, along_1 = 1.0, 0.0
        if strength > 1e-6:
            along_0, along_1 = pressure_0 / max(strength, 1e-12), pressure_1 / max(strength, 1e-12)
        elif error > 1e-9:
            along_0, along_1 = course_0 / max(error, 1e-12), course_1 / max(error, 1e-12)
        across_0, across_1 = -along_1, along_0
        side = course_0 * across_0 + course_1 * across_1
        if not abs(side) > 1e-12:
            side = first_0 * across_0 + first_1 * across_1
        if side < 0.0:
            across_0, across_1 = -across_0, -across_1
        frames[row, 0, 0], frames[row, 0, 1] = along_0, along_1
        frames[row, 1, 0], frames[row, 1, 1] = across_0, across_1
        states[row, 0] = strength
        states[row, 1] = along_0 * first_0 + along_1 * first_1
        states[row, 2] = across_0 * first_0 + across_1 * first_1
        states[row, 3] = weights[row, 0] * min(aside[row, 0], 12.0)
        states[row, 4] = along_0 * course_0 + along_1 * course_1
        states[row, 5] = across_0 * course_0 + across_1 * course_1
        for component in range(6):
            states[row, component] = within(
                states[row, component], lows[component], highs[component]
            )


@njit(
    types.void(
        _NUMBERS, _ALIVE, types.int64, types.int64, TABLE, VECTORS, TABLE, TABLE, NUMBERS,
        VECTORS, VECTORS, VECTORS, VECTORS, TABLE,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def turn(
    numbers, alive, count, moment, chosen, frames, heading, position, change, positions, headings,
    turns, actions, last,
):  # fmt: skip
    """Note the moment, and turn each ship as was `chosen` (alive, 2) in its own frame."""
    limit, most = numbers[TURN], numbers[HEADING]
    for row in range(count):
        world = alive[row]
        for axis in range(3):
            positions[world, moment, axis] = position[world, axis]
        moved = 0.0
        for axis in range(2):
            action = frames[row, 0, axis] * chosen[row, 0] + frames[row, 1, axis] * chosen[row, 1]
            action = within(action, -limit, limit)
            before = heading[world, axis]
            headings[world, moment, axis] = before
            turns[world, moment, axis] = last[world, axis]
            if moment > 0:
                moved += abs(action - actions[world, moment - 1, axis]) / (limit - -limit)
            actions[world, moment, axis] = action
            heading[world, axis] = within(before + action, -most, most)
            last[world, axis] = heading[world, axis] - before
        change[world] += moved / 2


@njit(
    types.int64(
        *_FIELD,
        types.int64,
        _NUMBERS,
        _ALIVE,
        types.int64,
        types.int64,
        TABLE,
        TABLE,
        TABLE,
        _ALIVE,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def move(
    rocks, cells, halves, rows, numbers, alive, count, steps, position, cosines, sines, outcomes
):
    """Move each ship ahead and tell what became of it; how many go on, the first of `alive`."""
    going = 0
    for row in range(count):
        world = alive[row]
        flat = cosines[world, 1]
        position[world, 0] += flat * cosines[world, 0] * numbers[STEP]
        position[world, 1] += flat * sines[world, 0] * numbers[STEP]
        position[world, 2] += sines[world, 1] * numbers[STEP]
        x, y, z = position[world, 0], position[world, 1], position[world, 2]
        reach, wide = numbers[REACH], numbers[HALF_WIDTH]
        square = nearest_to(rocks, cells, halves[world], world, x, y, z, reach, numbers[SLAB], rows)
        if square < reach * reach:
            outcomes[world] = HIT
        elif abs(y) > wide or abs(z) > wide:
            outcomes[world] = LEFT
        elif x >= numbers[LENGTH]:
            outcomes[world] = CROSSED
        elif steps * numbers[DT] >= numbers[LIMIT]:
            outcomes[world] = LATE
        else:
            alive[going] = world
            going += 1
    return going
