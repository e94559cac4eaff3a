"""Exact neighbours, ties by lowest index."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.learning.neighbors import NeighborIndex


def brute_force(points, queries, k):
    away = np.sqrt(((queries[:, None] - points[None]) ** 2).sum(axis=2))
    order = np.lexsort((np.broadcast_to(np.arange(len(points)), away.shape), away), axis=1)[:, :k]
    return np.take_along_axis(away, order, axis=1), order


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 30), st.integers(1, 4))
def test_neighbours_are_those_of_brute_force_even_with_many_ties(seed, count, size):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 3, size=(count, size)).astype(float)
    queries = rng.integers(0, 3, size=(5, size)).astype(float)
    k = int(rng.integers(1, count + 1))
    distances, indices = NeighborIndex(points).nearest(queries, k)
    wanted_distances, wanted = brute_force(points, queries, k)
    assert indices.tolist() == wanted.tolist()
    assert np.allclose(distances, wanted_distances, rtol=1e-15, atol=0)


def test_the_nearest_others_never_include_the_point_itself():
    points = np.array([[0.0], [0.0], [0.0], [5.0], [6.0]])
    others = NeighborIndex(points).nearest_others(2)
    assert others.tolist() == [[1, 2], [0, 2], [0, 1], [4, 0], [3, 0]]


def test_more_neighbours_than_points_is_refused():
    with pytest.raises(InvalidInputError, match="there are 3 pairs"):
        NeighborIndex(np.zeros((3, 1))).nearest(np.zeros((1, 1)), 4)
