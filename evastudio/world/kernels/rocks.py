"""The rocks near ships, one ship after another: see `evastudio.world.rocks` for what is what.

Every operation is that of the plain way, in its order and none contracted, so that both give the
same bits.
"""

from __future__ import annotations

import numpy as np
from numba import njit, types

PLACES = types.Array(types.float64, 2, "C", readonly=True)
WORLDS = (
    types.Array(types.float64, 3, "C", readonly=True),
    types.Array(types.int64, 2, "C", readonly=True),
    types.Array(types.float64, 1, "C", readonly=True),
    types.Array(types.int64, 1, "C", readonly=True),
    PLACES,
)
"""Rocks, cells and half widths of worlds; which of these each ship is in, and where."""
NUMBERS = types.Array(types.float64, 1, "C")
TABLE = types.Array(types.float64, 2, "C")
VECTORS = types.Array(types.float64, 3, "C")


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def slabs_between(place, low, high, size, count):
    """The first and the last of `count` slabs of `size` metres from `place + low` to `+ high`."""
    first, last = np.floor((place + low) / size), np.floor((place + high) / size)
    return max(np.int64(first), 0), min(np.int64(last), count - 1)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def rows_between(place, low, high, half, rows):
    """The first of the rows from `place + low` to `+ high`, and the one behind the last."""
    wide = rows / (2 * half)
    first = np.int64(np.floor((place + low + half) * wide))
    behind = np.int64(np.floor((place + high + half) * wide)) + 1
    return min(max(first, 0), rows), min(max(behind, 0), rows)


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_to(rocks, cells, half, world, x, y, z, reach, slab, rows):
    """The squared distance from a place to the nearest rock that may be within `reach`."""
    first, behind = rows_between(y, -reach, reach, half, rows)
    near, far_off = slabs_between(x, -reach, reach, slab, (cells.shape[1] - 1) // rows)
    floor, ceiling = z - reach, z + reach
    least = np.inf
    for column in range(near, far_off + 1):
        start = cells[world, column * rows + first]
        stop = cells[world, column * rows + behind]
        for rock in range(start, stop):
            up = rocks[world, rock, 2]
            if up >= floor and up <= ceiling:
                ahead, aside = rocks[world, rock, 0] - x, rocks[world, rock, 1] - y
                above = up - z
                least = min(least, ahead * ahead + aside * aside + above * above)
    return least


@njit(cache=True, nogil=True, error_model="numpy")
def worst_to(
    rocks, cells, half, world, position, forward, left, up, radius, sight, slab, rows, out, menaces
):
    """The rocks that most endanger one ship at `position` (3,), its axes (3,) each.

    `out` (count, 3) and `menaces` (count,) are filled from the front, worst first; `menaces` comes
    filled with `sight`, which is no threat any more.
    """
    count = len(menaces)
    base, tip, far = sight / 2.5 + radius + 1.0, radius, sight + radius
    low, high = np.empty(3), np.empty(3)
    for axis in range(3):
        along = forward[axis]
        flat = np.sqrt(max(1.0 - along * along, 0.0))
        low[axis] = min(-base * flat, far * along - tip * flat)
        high[axis] = max(base * flat, far * along + tip * flat)
    x, y, z = position[0], position[1], position[2]
    first, behind = rows_between(y, low[1], high[1], half, rows)
    near, far_off = slabs_between(x, low[0], high[0], slab, (cells.shape[1] - 1) // rows)
    floor, ceiling = z + low[2], z + high[2]
    for column in range(near, far_off + 1):
        start = cells[world, column * rows + first]
        stop = cells[world, column * rows + behind]
        for rock in range(start, stop):
            c = rocks[world, rock, 2]
            if c < floor or c > ceiling:
                continue
            a, b = rocks[world, rock, 0] - x, rocks[world, rock, 1] - y
            c -= z
            ahead = a * forward[0] + b * forward[1] + c * forward[2]
            if not ahead > 0.0:
                continue
            aside = a * left[0] + b * left[1] + c * left[2]
            above = a * up[0] + b * up[1] + c * up[2]
            lateral = np.sqrt(aside * aside + above * above)
            menace = max(ahead - radius / 2, 0.0) + 2.5 * max(lateral - radius, 0.0)
            rank = count
            while rank > 0 and menace < menaces[rank - 1]:
                rank -= 1
            if rank == count:
                continue
            for place in range(count - 1, rank, -1):
                menaces[place] = menaces[place - 1]
                for axis in range(3):
                    out[place, axis] = out[place - 1, axis]
            menaces[rank] = menace
            out[rank, 0], out[rank, 1], out[rank, 2] = ahead, aside, above


@njit(
    types.void(*WORLDS, types.float64, types.float64, types.int64, NUMBERS),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def nearest_squares(rocks, cells, halves, own, position, reach, slab, rows, out):
    """`nearest_to` for every ship, to `out`."""
    for ship in range(len(position)):
        x, y, z = position[ship, 0], position[ship, 1], position[ship, 2]
        world = own[ship]
        out[ship] = nearest_to(rocks, cells, halves[world], world, x, y, z, reach, slab, rows)


@njit(
    types.void(
        *WORLDS,
        *(PLACES, PLACES, PLACES),
        *(types.float64, types.float64, types.float64, types.int64),
        *(VECTORS, TABLE),
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def worst_threats(
    rocks, cells, halves, own, position, forward, left, up, radius, sight, slab, rows, out, menaces
):
    """`worst_to` for every ship, to `out` (ships, count, 3) and `menaces` (ships, count)."""
    for ship in range(len(position)):
        world = own[ship]
        worst_to(
            rocks, cells, halves[world], world, position[ship], forward[ship], left[ship],
            up[ship], radius, sight, slab, rows, out[ship], menaces[ship],
        )  # fmt: skip
