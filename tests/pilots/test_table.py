"""Reinforcement learning by tables."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.pilots.straight import StraightPilot
from evastudio.pilots.table import Counted, Grid, learn_table, table_bytes
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds


def test_the_papers_table_takes_eight_gigabytes_for_its_values() -> None:
    assert table_bytes(9, 10, 9) == (10**9, 8 * 10**9, 72 * 10**9)


def test_a_grid_puts_equally_many_states_in_each_part() -> None:
    states = np.random.default_rng(0).normal(size=(8_000, 2))
    grid = Grid.of(states, 4)
    assert grid.cells == 16
    for column in range(2):
        part = grid.cell(states) // 4 if column == 0 else grid.cell(states) % 4
        assert np.bincount(part).tolist() == [2_000] * 4


def test_a_grid_too_large_for_a_machine_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="1,000,000,000 cells"):
        Grid.of(np.random.default_rng(0).normal(size=(100, 9)), 10)


def test_values_are_those_of_the_transitions_counted() -> None:
    # Cell 0 leads to 1 for nothing; 1 ends with 1 three times in four, and with -1 otherwise.
    counted = Counted(2, 2)
    ended = np.array([False, True, True, True, True])
    here, there = np.array([0, 1, 1, 1, 1]), np.array([1, 0, 0, 0, 0])
    rewards = np.array([0.0, 1.0, 1.0, 1.0, -1.0])
    counted.add(here, np.zeros(5, dtype=np.int64), there, rewards, ended)
    values = counted.solve(0.9, np.zeros((2, 2)), within=1e-9)
    assert values == pytest.approx(np.array([[0.45, 0.0], [0.5, 0.0]]))
    assert counted.known(values)[:, 1].tolist() == [-np.inf, -np.inf]


def test_a_coarse_table_is_better_than_no_action_and_repeats(
    asteroids: Callable[..., Scene],
) -> None:
    scene = asteroids(density=4.0, half_width=100.0)
    seeds = world_seeds(5, 20)
    first, second = (learn_table(scene, "canonical", 2, steps=12_000, seed=1) for _ in range(2))
    flown = roll_out(scene, first.pilot, seeds)
    assert np.array_equal(flown.steps, roll_out(scene, second.pilot, seeds).steps)
    assert flown.steps.mean() > roll_out(scene, StraightPilot(), seeds).steps.mean()
    assert 0 < first.cells_seen <= 64
    assert first.cells_seen <= first.pairs_seen <= 9 * first.cells_seen


def test_symbols_are_refused() -> None:
    crowd = load_scene_file(shipped() / "scenes" / "crowd.py")()
    with pytest.raises(InvalidInputError, match="two actions"):
        learn_table(crowd, next(iter(crowd.perceptions)), 2, steps=100, seed=1)
