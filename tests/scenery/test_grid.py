"""The grid that people walk on: who is where, who is near, and how far the way is free."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from evastudio.scenery.grid import (
    AHEAD,
    IN_A_ROW,
    clearances,
    eighths,
    looked_up,
    nearest,
    occupied,
    turned_back,
    window,
)

SIDE = 12
AROUND = window(False, 5)


def scattered(seed: int, people: int, side: int = SIDE) -> tuple[np.ndarray, np.ndarray]:
    """Two worlds of people in cells of their own, some beyond the edge, and their ways."""
    rng = np.random.default_rng(seed)
    spots = np.stack([rng.choice(side**2, people, replace=False) for _ in range(2)])
    cells = np.stack([spots % side, spots // side], axis=2)
    return cells + side * rng.integers(-2, 3, size=cells.shape), rng.integers(8, size=spots.shape)


def test_headings_are_counted_in_eighths_also_beyond_a_full_turn() -> None:
    headings = np.pi / 4 * np.array([0.0, 1.0, 7.0, 8.0, -1.0, 17.0])
    assert eighths(headings).tolist() == [0, 1, 7, 0, 7, 1]


def test_a_cell_beyond_the_edge_is_the_one_on_the_other_side() -> None:
    ground = occupied(np.array([[(SIDE, -1)]]), SIDE)
    assert np.argwhere(ground).tolist() == [[0, SIDE - 1, 0]]
    assert looked_up(ground, np.array([[(0, SIDE - 1), (1, 1)]])).tolist() == [[True, False]]


def test_the_nearest_are_those_that_measuring_everybody_finds() -> None:
    cells, facing = scattered(3, 14)
    found = nearest(cells, facing, SIDE, AROUND, 3)
    for world in range(2):
        apart = cells[world][None] - cells[world][:, None]
        apart = (apart + SIDE // 2) % SIDE - SIDE // 2
        far = np.hypot(apart[..., 0], apart[..., 1])
        np.fill_diagonal(far, np.inf)
        for one, distances in enumerate(np.sort(far, axis=1)):
            there = distances[distances <= 5.0][:3]
            seen = found[world, one][found[world, one] >= 0]
            assert len(seen) == len(there)
            near = AROUND[facing[world, one], seen]
            np.testing.assert_allclose(np.hypot(*near.T), there)


@pytest.mark.parametrize("ahead", [True, False])
@pytest.mark.parametrize(("people", "side"), [(1, 4), (16, 4), (5, SIDE), (60, SIDE), (144, SIDE)])
def test_looking_at_many_at_once_finds_what_looking_cell_by_cell_does(
    ahead: bool, people: int, side: int
) -> None:
    cells, facing = scattered(people, people, side)
    table, ways = window(ahead, 8), (0, 1, -1, 2, -2)
    ground = occupied(cells, side)
    found = nearest(cells, facing, side, table, 3)
    room = clearances(cells, facing, side, ways)
    for world, one in np.ndindex(facing.shape):
        own, way = cells[world, one], facing[world, one]
        there = [at for at, cell in enumerate(table[way]) if looked(ground, world, own + cell)]
        assert found[world, one].tolist() == [*there, -1, -1, -1][:3]
        for aside, free in zip(ways, room[world, one], strict=True):
            line = [own + far * AHEAD[(way + aside) % 8] for far in range(1, IN_A_ROW + 1)]
            taken = [looked(ground, world, cell) for cell in line]
            assert free == (*taken, True).index(True)


def test_looking_around_in_a_great_crowd_takes_little_memory() -> None:
    rng = np.random.default_rng(0)
    people, side = 20_000, 400
    spots = rng.choice(side**2, people, replace=False)
    cells = np.stack([spots % side, spots // side], axis=1)[None]
    facing = rng.integers(8, size=(1, people))
    tracemalloc.start()
    nearest(cells, facing, side, window(False, 8), 3)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 10e6  # 500 bytes for each


def looked(ground, world, cell) -> bool:
    return bool(ground[world, cell[1] % ground.shape[1], cell[0] % ground.shape[2]])


def test_nobody_behind_is_in_the_window_ahead() -> None:
    for way, cells in enumerate(window(True, 5)):
        ahead = turned_back(cells.astype(np.float64)[None], np.array([way]))[0, :, 0]
        assert (ahead > 0).all()


def test_free_cells_are_counted_until_somebody_stands_there() -> None:
    cells = np.array([[(2, 2), (5, 2), (2, 3)]])
    facing = np.array([[0, 4, 2]])
    room = clearances(cells, facing, SIDE, (0, 2))
    assert room[0, 0].tolist() == [2.0, 0.0]
    assert room[0, 1].tolist() == [2.0, IN_A_ROW]
