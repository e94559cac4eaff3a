"""Rocks of many worlds, sorted into cells, and which of them are near a ship.

Each way of looking is written twice, plainly and compiled for many worlds at a time; both give
the same bits, so which of the two looks is never seen in a result.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from evastudio.world.compiled import is_compiled, is_loaded
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

Way = Literal["compiled", "plain"]
SLAB = 8.0
"""The field is cut into slabs so long along x, and each of them into ROWS along y."""
ROWS = 32
FAR_AWAY = 1e6
MOST = 8
"""No more rocks than this are ever looked at closely."""
MANY = 16
"""From so many worlds on it pays to load compiled code; once it is loaded it always pays."""


def in_cells(rocks: Array, length: float, half: float) -> dict[str, AnyArray]:
    """What is fixed in worlds with these `rocks` (worlds, N, 3).

    They lie from 0 to `length` along x and within `half` of the middle along y.
    """
    slabs = round(length / SLAB)
    slab = np.clip(np.floor(rocks[:, :, 0] / SLAB), 0, slabs - 1)
    row = np.clip(np.floor((rocks[:, :, 1] / half + 1.0) * (ROWS / 2)), 0, ROWS - 1)
    cell = (slab * ROWS + row).astype(np.int16)  # few enough, and sorted faster than others
    order = np.argsort(cell, axis=1, kind="stable")
    cells = np.zeros((len(rocks), slabs * ROWS + 1), dtype=np.int64)
    for counts, world in zip(cells, cell, strict=True):
        np.cumsum(np.bincount(world, minlength=slabs * ROWS), out=counts[1:])
    return {
        "rocks": np.stack(
            [world.take(own, axis=0) for world, own in zip(rocks, order, strict=True)]
        ),
        "cells": cells,
        "half": np.full(len(rocks), half),
    }


def rocks_within(
    snapshot: Snapshot, low: Array, high: Array
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Rocks that lie between `low` and `high` (worlds, 3) of the ship, and perhaps a few more.

    Returns their x, y and z from the ship, each (worlds, K), and which of the K are rocks at all.
    K is at least MOST.
    """
    fixed, own = snapshot.shared()
    cells, position, half = fixed["cells"], snapshot["position"], fixed["half"][own]
    count, slabs = fixed["rocks"].shape[1], (cells.shape[1] - 1) // ROWS
    world = own[:, None]
    first = np.floor((position[:, 0] + low[:, 0]) / SLAB).astype(np.int64)
    last = np.floor((position[:, 0] + high[:, 0]) / SLAB).astype(np.int64)
    slab = first[:, None] + np.arange(int((last - first).max()) + 1)
    outside = (slab > last[:, None]) | (slab < 0) | (slab >= slabs)
    slab = np.clip(slab, 0, slabs - 1)
    wide = ROWS / (2 * half)
    first = np.floor((position[:, 1] + low[:, 1] + half) * wide).astype(np.int64)
    last = np.floor((position[:, 1] + high[:, 1] + half) * wide).astype(np.int64)
    start = cells[world, slab * ROWS + np.clip(first, 0, ROWS)[:, None]]
    stop = cells[world, slab * ROWS + np.clip(last + 1, 0, ROWS)[:, None]]
    run = np.arange(max(1, int((stop - start).max())))
    index = (start + world * count)[:, :, None] + run
    candidate = (run < (stop - start)[:, :, None]) & ~outside[:, :, None]
    # By height, most of them fall away before their other coordinates are fetched.
    rocks = fixed["rocks"].reshape(-1, 3)
    height = rocks.reshape(-1).take(index * 3 + 2, mode="clip")
    candidate &= height >= (position[:, 2] + low[:, 2])[:, None, None]
    candidate &= height <= (position[:, 2] + high[:, 2])[:, None, None]
    owner = np.nonzero(candidate)[0]
    counts = np.bincount(owner, minlength=snapshot.worlds)
    slot = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    near = np.full((3, snapshot.worlds, max(MOST, int(counts.max()))), FAR_AWAY)
    near[:, owner, slot] = (rocks[index[candidate]] - position[owner]).T
    return near[0], near[1], near[2], near[0] < FAR_AWAY


def nearest_square(snapshot: Snapshot, reach: float, way: Way | None = None) -> Array:
    """Squared distance to the nearest rock's centre, (worlds,), where that is within `reach`.

    Elsewhere that of a rock farther off, or infinite.
    """
    if _by_compiled(snapshot, way):
        from evastudio.world.kernels.rocks import nearest_squares  # numba loads slowly

        found = np.empty(snapshot.worlds)
        nearest_squares(*_laid_out(snapshot), reach, SLAB, ROWS, found)
        return found
    box = np.full((snapshot.worlds, 3), reach)
    x, y, z, present = rocks_within(snapshot, -box, box)
    return np.asarray(np.where(present, x**2 + y**2 + z**2, np.inf).min(axis=1))


def worst_threats(
    snapshot: Snapshot,
    axes: tuple[Array, Array, Array],
    radius: float,
    sight: float,
    way: Way | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """The MOST rocks of that `radius` that most endanger the ship, worst first.

    A threat counts by its distance ahead plus 2.5 times its clearance to the side, up to `sight`;
    nothing behind is one. `axes` are the ship's forward, left and up, each (worlds, 3). Returns
    vectors along them, shape (worlds, MOST, 3), and which of them exist.
    """
    if _by_compiled(snapshot, way):
        from evastudio.world.kernels import rocks as kernels  # numba loads slowly

        threats = np.full((snapshot.worlds, MOST, 3), (FAR_AWAY, 0.0, 0.0))
        menace = np.full((snapshot.worlds, MOST), sight)
        laid_out = _laid_out(snapshot)
        kernels.worst_threats(*laid_out, *axes, radius, sight, SLAB, ROWS, threats, menace)
        return threats, menace < sight
    forward = axes[0]
    # What can count lies within a blunt cone: a wide disc at the ship, a small one at its tip.
    base, tip, far = sight / 2.5 + radius + 1.0, radius, sight + radius
    flat = np.sqrt(np.maximum(1.0 - forward**2, 0.0))
    low = np.minimum(-base * flat, far * forward - tip * flat)
    high = np.maximum(base * flat, far * forward + tip * flat)
    x, y, z, present = rocks_within(snapshot, low, high)
    ahead, aside, above = (
        x * axis[:, 0, None] + y * axis[:, 1, None] + z * axis[:, 2, None] for axis in axes
    )
    lateral = np.sqrt(aside**2 + above**2)
    menace = np.maximum(ahead - radius / 2, 0.0) + 2.5 * np.maximum(lateral - radius, 0.0)
    menace = np.where(present & (ahead > 0.0), menace, np.inf)
    index = smallest(menace, MOST)
    exists = np.take_along_axis(menace, index, axis=1) < sight
    threats = np.stack(
        [np.take_along_axis(values, index, axis=1) for values in (ahead, aside, above)], axis=2
    )
    return np.where(exists[:, :, None], threats, (FAR_AWAY, 0.0, 0.0)), exists


def smallest(values: Array, count: int) -> NDArray[np.int64]:
    """Columns of the `count` smallest values of each row, in order; `count` is at most MOST."""
    index = np.argpartition(values, count - 1, axis=1)[:, :count]
    order = np.argsort(np.take_along_axis(values, index, axis=1), axis=1, kind="stable")
    return np.take_along_axis(index, order, axis=1)


def _by_compiled(snapshot: Snapshot, way: Way | None) -> bool:
    if way is None:
        return is_loaded() or (snapshot.worlds >= MANY and is_compiled())
    return way == "compiled"


def _laid_out(snapshot: Snapshot) -> tuple[AnyArray, ...]:
    """Rocks, cells and half widths of worlds, which of these each ship is in, and where."""
    fixed, own = snapshot.shared()
    arrays = (fixed["rocks"], fixed["cells"], fixed["half"], own, snapshot["position"])
    return tuple(np.ascontiguousarray(array) for array in arrays)
