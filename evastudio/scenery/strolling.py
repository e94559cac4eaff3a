"""Walking about on a square of cells: what one chooses among, and what one perceives of others.

Everybody stands in a cell, turned one of eight ways, and turns by an eighth, walks on into the
next cell, or stands; `evastudio.scenery.grid` says who is where.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from evastudio.scenery.boulder import FALL_S
from evastudio.scenery.grid import (
    EIGHTH,
    IN_A_ROW,
    clearances,
    eighths,
    nearest,
    turned_back,
    window,
)
from evastudio.world.scene import Percept, Perception
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array, Box, Field, Symbols

CELL = 0.7
"""Metres from cell to cell."""
SIGHT = 8
"""Cells beyond this are not perceived."""
NEAREST = 3
PATHS = {"ahead": 0, "half_left": 1, "half_right": -1, "left": 2, "right": -2}
"""Eighths from the way one faces."""

STAND, LEFT, RIGHT, WALK = range(4)
SYMBOLS = Symbols(
    ("stand", "turn left", "turn right", "walk on"),
    moves=((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)),
)
MOVES = np.array(SYMBOLS.moves)
"""Turn and walk of each symbol."""


class Square(Protocol):
    """A scene on such a square."""

    side: int
    """Cells along each side."""
    action: Box
    """Turn, walk, and what else there is."""


def symbols(actions: Array) -> NDArray[np.int64]:
    """The symbol that each of `actions` (..., 6) comes to: turning goes before walking."""
    return np.select(
        [actions[..., 0] > 0.5, actions[..., 0] < -0.5, actions[..., 1] > 0.5],
        [LEFT, RIGHT, WALK],
        default=STAND,
    )


def cells_of(snapshot: Snapshot) -> NDArray[np.int64]:
    """The cell that everybody stands in, (worlds, N, 2), not wrapped."""
    return np.asarray(np.rint(snapshot["position"] / CELL).astype(np.int64))


def strolled(
    snapshot: Snapshot, side: int, whim: Array, room: float, wander: float, rest: float
) -> NDArray[np.int64]:
    """What somebody does who turns to the freer side before somebody comes too near, (worlds, N).

    whim: a random number of each, 0 to 1. room: cells kept free ahead. wander, rest: how often one
    turns or stands still though nothing is in the way, shares of the decisions.
    """
    free = clearances(cells_of(snapshot), eighths(snapshot["heading"]), side, (0, 1, -1))
    ahead, left, right = free[:, :, 0], free[:, :, 1], free[:, :, 2]
    freer = np.where(left > right, LEFT, np.where(right > left, RIGHT, 0))
    freer = np.where(freer == 0, np.where(whim < 0.5, LEFT, RIGHT), freer)
    return np.select(
        [ahead <= room, whim < wander / 2, whim > 1 - wander / 2, whim < wander / 2 + rest],
        [freer, LEFT, RIGHT, STAND],
        default=WALK,
    )


def felt(
    snapshot: Snapshot, side: int, table: NDArray[np.int64], felt_there: Array, count: int
) -> Array:
    """Towards the nearest people in `table`, as one sees them: (worlds, N, count, 2)."""
    facing = eighths(snapshot["heading"])
    return felt_there[facing[..., None], nearest(cells_of(snapshot), facing, side, table, count)]


def felt_in(table: NDArray[np.int64]) -> Array:
    """Somebody in each cell of `table` (8, K, 2), and last of all nobody: (8, K + 1, 2).

    Ahead and left; 1 long in the next cell, shorter the farther, 0 where there is nobody.
    """
    distance = np.hypot(table[..., 0], table[..., 1])
    weight = np.exp(-(distance - 1.0) / 3.0) / np.maximum(distance, 1.0)
    near = turned_back(table.astype(np.float64), np.arange(8)) * weight[..., None]
    return np.concatenate([near, np.zeros((8, 1, 2))], axis=1)


AROUND = window(False, SIGHT)
AHEAD_ONLY = window(True, SIGHT)
FELT, FELT_AHEAD = felt_in(AROUND), felt_in(AHEAD_ONLY)
FREE = 1.0 - np.exp(-np.arange(IN_A_ROW + 1) / 2.0)
"""What so many free cells in a row come to."""


class Grid(Perception):
    """What perceptions of the square have in common: symbols, and the nearest people."""

    action = SYMBOLS

    def __init__(self, scene: Square) -> None:
        self.side, self.fields = scene.side, scene.action.size

    def applies(self, snapshot: Snapshot) -> NDArray[np.bool_]:
        return np.asarray(snapshot["boulder"][:, 2] < FALL_S)

    def to_own(self, frame: AnyArray, actions: Array) -> Array:
        return symbols(actions)[..., None].astype(np.float64)

    def to_world(self, frame: AnyArray, actions: Array) -> Array:
        given = np.zeros((*actions.shape[:-1], self.fields))
        given[..., :2] = MOVES[actions[..., 0].astype(np.int64)]
        return given


def separations(name: str, unit: str, reach: float) -> tuple[Field, ...]:
    """The fields of the vectors to the nearest people."""
    return tuple(
        Field(f"{name}_{axis}{number}", unit, -reach, reach)
        for number in range(1, NEAREST + 1)
        for axis in ("x", "y")
    )


class PaperState(Grid):
    """Exactly the paper's: orientation, and the separations from the three closest people."""

    name = "paper"
    summary = "The paper's own: which way one faces, and the three nearest people on any side."
    state = Box(
        (
            Field("east", "1", -1.0, 1.0),
            Field("north", "1", -1.0, 1.0),
            *separations("apart", "cells", float(SIGHT + 1)),
        )
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        way = eighths(snapshot["heading"])
        found = nearest(cells_of(snapshot), way, self.side, AROUND, NEAREST)
        facing = way * EIGHTH
        apart = np.where(found[..., None] < 0, SIGHT + 1.0, AROUND[way[..., None], found])
        states = np.concatenate(
            [
                np.cos(facing)[..., None],
                np.sin(facing)[..., None],
                apart.reshape(*facing.shape, -1),
            ],
            axis=2,
        )
        return Percept(states, np.zeros((*facing.shape, 0)))


class Own(Grid):
    """The three closest people as one sees them, near ones larger than far ones."""

    name = "own"
    summary = "The three nearest people on any side, seen from the character."
    state = Box(separations("near", "1", 1.0))
    ahead_only = False

    def perceive(self, snapshot: Snapshot) -> Percept:
        seen = (AHEAD_ONLY, FELT_AHEAD) if self.ahead_only else (AROUND, FELT)
        own = felt(snapshot, self.side, *seen, NEAREST)
        states = own.reshape(*own.shape[:2], -1)
        return Percept(self.state.clip(states), np.zeros((*own.shape[:2], 0)))


class Ahead(Own):
    """The three closest people ahead."""

    name = "ahead"
    summary = "The three nearest people ahead, seen from the character; nobody behind counts."
    ahead_only = True


class Paths(Grid):
    """How far one could walk: straight on, and to each side."""

    name = "paths"
    summary = "How many cells are free ahead and to either side, and who is near."
    state = Box(
        (
            *(Field(f"free_{way}", "1", 0.0, 1.0) for way in PATHS),
            *separations("near", "1", 1.0)[:2],
        )
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        facing = eighths(snapshot["heading"])
        room = clearances(cells_of(snapshot), facing, self.side, tuple(PATHS.values()))
        closest = felt(snapshot, self.side, AROUND, FELT, 1)[:, :, 0]
        states = np.concatenate([FREE[room], closest], axis=2)
        return Percept(self.state.clip(states), np.zeros((*room.shape[:2], 0)))
