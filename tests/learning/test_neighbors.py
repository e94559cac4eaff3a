"""Both ways to search agree, bit for bit, and with brute force; points come and go."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.neighbors import NeighborIndex, Way
from evastudio.learning.plain_search import vector_medians
from evastudio.world.spaces import Array

WAYS: tuple[Way, ...] = ("compiled", "plain")


def brute(points: Array, queries: Array, k: int, skip_own: bool = False) -> np.ndarray:
    """Numbers by float32 distance, the lower first among equals."""
    near, asked = points.astype(np.float32), queries.astype(np.float32)
    found = []
    for row, query in enumerate(asked):
        squares = np.zeros(len(near), np.float32)
        for component in range(near.shape[1]):
            squares += (near[:, component] - query[component]) ** 2
        if skip_own:
            squares[row] = np.inf
        found.append(np.lexsort((np.arange(len(near)), squares))[:k])
    return np.array(found)


def normal(rng: np.random.Generator, n: int, d: int) -> Array:
    return rng.normal(size=(n, d))


def clustered(rng: np.random.Generator, n: int, d: int) -> Array:
    centers = rng.normal(size=(5, d)) * 10
    return centers[rng.integers(0, 5, n)] + rng.normal(size=(n, d)) * 0.01


def duplicated(rng: np.random.Generator, n: int, d: int) -> Array:
    return np.asarray(rng.normal(size=(max(1, n // 7), d))[rng.integers(0, max(1, n // 7), n)])


def gridded(rng: np.random.Generator, n: int, d: int) -> Array:
    return rng.integers(0, 3, (n, d)).astype(np.float64)


def identical(rng: np.random.Generator, n: int, d: int) -> Array:
    return np.ones((n, d))


def flat(rng: np.random.Generator, n: int, d: int) -> Array:
    points = np.zeros((n, d))
    points[:, 0] = rng.normal(size=n)
    return points


def huge(rng: np.random.Generator, n: int, d: int) -> Array:
    return np.asarray(rng.normal(size=(n, d)) * 10.0 ** rng.integers(-8, 16, (n, 1))).clip(
        -1e15, 1e15
    )


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", [normal, clustered, duplicated, gridded, identical, flat, huge])
@pytest.mark.parametrize(
    ("n", "d", "k"), [(1, 1, 1), (20, 3, 5), (700, 8, 5), (1500, 2, 15), (130, 30, 9)]
)
def test_it_finds_what_brute_force_finds(
    way: Way, kind: Callable[[np.random.Generator, int, int], Array], n: int, d: int, k: int
) -> None:
    rng = np.random.default_rng(n + d)
    points = kind(rng, n, d)
    queries = np.concatenate([kind(rng, 30, d), points[:10]])
    index = NeighborIndex(points, way)
    distances, numbers = index.nearest(queries, min(k, n))
    assert np.array_equal(numbers, brute(points, queries, min(k, n)))
    assert (np.diff(distances, axis=1) >= 0).all()
    if n > k:
        assert np.array_equal(index.nearest_others(k), brute(points, points, k, skip_own=True))


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 400), st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_both_ways_agree_through_additions_and_removals(n: int, d: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = (normal, clustered, duplicated, gridded)
    points = kinds[seed % 4](rng, n, d)
    indexes = [NeighborIndex(points, way) for way in WAYS]
    for _ in range(4):
        if rng.random() < 0.5 or len(points) < 3:
            more = kinds[seed % 4](rng, int(rng.integers(1, 40)), d)
            points = np.concatenate([points, more])
            for index in indexes:
                index.add(more)
        else:
            gone = rng.choice(len(points), len(points) // 3, replace=False)
            points = np.delete(points, gone, axis=0)
            for index in indexes:
                index.remove(gone)
        queries = kinds[seed % 4](rng, 8, d)
        k = min(5, len(points))
        expected = brute(points, queries, k)
        for index in indexes:
            assert len(index) == len(points)
            assert np.array_equal(index.nearest(queries, k)[1], expected)


@pytest.mark.parametrize("way", WAYS)
def test_many_queries_are_answered_as_one_is(way: Way) -> None:
    rng = np.random.default_rng(3)
    points, queries = rng.normal(size=(3000, 6)), rng.normal(size=(2500, 6))
    index = NeighborIndex(points, way)
    distances, numbers = index.nearest(queries, 7)
    for row in (0, 1, 1234, 2499):
        alone = index.nearest(queries[row : row + 1], 7)
        assert np.array_equal(alone[0][0], distances[row])
        assert np.array_equal(alone[1][0], numbers[row])


@pytest.mark.parametrize("way", WAYS)
def test_distances_are_those_of_float64_but_for_rounding(way: Way) -> None:
    rng = np.random.default_rng(4)
    points, queries = rng.normal(size=(500, 8)), rng.normal(size=(50, 8))
    distances, numbers = NeighborIndex(points, way).nearest(queries, 5)
    exact = np.linalg.norm(points[numbers] - queries[:, None, :], axis=2)
    assert distances == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("way", WAYS)
def test_infinite_queries_and_ten_thousand_components_are_borne(way: Way) -> None:
    rng = np.random.default_rng(5)
    wide = rng.normal(size=(40, 10_000))
    assert np.array_equal(NeighborIndex(wide, way).nearest(wide, 1)[1][:, 0], np.arange(40))
    far = np.full((1, 3), 1e300)
    numbers = NeighborIndex(rng.normal(size=(50, 3)), way).nearest(far, 5)[1]
    assert sorted(set(numbers[0])) == list(numbers[0])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("k", [0, 11])
def test_more_neighbours_than_points_are_refused(way: Way, k: int) -> None:
    index = NeighborIndex(np.zeros((10, 2)), way)
    with pytest.raises(InvalidInputError, match="there are 10 pairs"):
        index.nearest(np.zeros((1, 2)), k)
    with pytest.raises(InvalidInputError, match="at least 11"):
        index.nearest_others(10)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", [normal, duplicated, gridded, identical])
@pytest.mark.parametrize(("k", "gap"), [(1, 0), (5, 0), (5, 7), (12, 30)])
def test_points_close_in_time_do_not_count(
    way: Way, kind: Callable[[np.random.Generator, int, int], Array], k: int, gap: int
) -> None:
    rng = np.random.default_rng(k + gap)
    points = kind(rng, 200, 4)
    moments = np.concatenate([np.arange(90), (7 << 40) + np.arange(110)])
    index = NeighborIndex(points, way)
    for gone in (np.arange(0), np.arange(3, 200, 19)):
        index.remove(gone)
        points, moments = np.delete(points, gone, axis=0), np.delete(moments, gone)
        found = index.nearest_others(k, moments, gap)
        for row, query in enumerate(points):
            counting = np.flatnonzero(abs(moments - moments[row]) > gap)
            assert np.array_equal(found[row], counting[brute(points[counting], query[None], k)[0]])


@pytest.mark.parametrize("kind", [normal, clustered, duplicated, gridded, identical])
@pytest.mark.parametrize(("m", "k", "gap"), [(1, 5, 0), (2, 5, 3), (2, 9, 0), (12, 4, 5)])
def test_deviations_from_the_median_agree_bit_for_bit(
    kind: Callable[[np.random.Generator, int, int], Array], m: int, k: int, gap: int
) -> None:
    rng = np.random.default_rng(m + k)
    points, actions = kind(rng, 1200, 5), kind(rng, 1200, m)
    moments = rng.integers(0, 900, 1200) if gap else None
    by_way = []
    for way in WAYS:
        index = NeighborIndex(points, way)
        by_way.append(index.median_deviations(actions, k, moments, gap))
        medians = vector_medians(actions[index.nearest_others(k, moments, gap)])
        assert by_way[-1] == pytest.approx(np.linalg.norm(medians - actions, axis=1))
    assert np.array_equal(*by_way)


@pytest.mark.parametrize("way", WAYS)
def test_deviations_follow_points_that_come_and_go(way: Way) -> None:
    rng = np.random.default_rng(9)
    points, actions = rng.normal(size=(300, 3)), rng.normal(size=(300, 2))
    index = NeighborIndex(points[:200], way)
    index.add(points[200:])
    gone = rng.permutation(300)[:80]
    index.remove(gone)
    kept = np.delete(np.arange(300), gone)
    expected = NeighborIndex(points[kept], "plain").median_deviations(actions[kept], 5)
    assert np.array_equal(index.median_deviations(actions[kept], 5), expected)


def test_the_vector_median_is_the_action_nearest_to_all_others() -> None:
    sets = np.array([[[0.0, 0.0], [1.0, 0.0], [9.0, 9.0]], [[5.0, 5.0], [5.0, 5.0], [0.0, 0.0]]])
    assert vector_medians(sets).tolist() == [[1.0, 0.0], [5.0, 5.0]]


@pytest.mark.parametrize("way", WAYS)
def test_too_few_others_are_refused(way: Way) -> None:
    index = NeighborIndex(np.zeros((10, 2)), way)
    moments = np.arange(10)
    with pytest.raises(InvalidInputError, match="up to 7 are too close in time; at least 11"):
        index.nearest_others(4, moments, 3)
    with pytest.raises(InvalidInputError, match="one for each of the 10 pairs"):
        index.nearest_others(1, moments[:9])
    with pytest.raises(InvalidInputError, match="gap of 0 or more"):
        index.nearest_others(1, moments, -1)


def test_many_at_once_may_ask_for_batches() -> None:
    rng = np.random.default_rng(11)
    index = NeighborIndex(rng.normal(size=(20_000, 4)), "compiled")
    queries = rng.normal(size=(4000, 4))
    expected = index.nearest(queries, 5)[1]
    others = index.nearest_others(3)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: index.nearest(queries, 5)[1], range(8)):
            assert np.array_equal(found, expected)
        for found in pool.map(lambda _: index.nearest_others(3), range(4)):
            assert np.array_equal(found, others)


def test_a_pickled_index_finds_the_same() -> None:
    rng = np.random.default_rng(12)
    index = NeighborIndex(rng.normal(size=(900, 3)), "compiled")
    index.add(rng.normal(size=(20, 3)))
    index.remove(np.arange(5))
    again = pickle.loads(pickle.dumps(index))
    assert np.array_equal(again.nearest_others(4), index.nearest_others(4))


@pytest.mark.parametrize("rows", [1, 2000])
def test_states_of_another_width_are_refused(rows: int) -> None:
    rng = np.random.default_rng(13)
    learner = KNNPolicy().fit(rng.normal(size=(50, 3)), rng.normal(size=50)).prepare("compiled")
    with pytest.raises(InvalidInputError, match="expected \\(rows, 3\\)"):
        learner.decide(np.zeros((rows, 4)))


@pytest.mark.parametrize("weights", ["uniform", "distance"])
@pytest.mark.parametrize("kind", [normal, duplicated, gridded, identical, huge])
@pytest.mark.parametrize(("k", "m"), [(1, 1), (5, 2), (23, 3)])
def test_both_ways_decide_the_same_bit_for_bit(
    weights: str, kind: Callable[[np.random.Generator, int, int], Array], k: int, m: int
) -> None:
    rng = np.random.default_rng(k)
    states, actions = kind(rng, 500, 4), rng.normal(size=(500, m))
    learner = KNNPolicy(k, weights).fit(states, actions)
    queries = np.concatenate([states[:40], kind(rng, 40, 4)])
    by_way = [learner.prepare(way).decide(queries) for way in WAYS]
    assert np.array_equal(*by_way)
