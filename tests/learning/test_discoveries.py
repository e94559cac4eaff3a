"""The cut that few ordinary scores pass."""

import numpy as np
import pytest

from evastudio.learning.discoveries import far_fence, least_discovery


def test_ordinary_scores_give_none():
    rng = np.random.default_rng(0)
    assert least_discovery(rng.exponential(size=5000), 0.2) == np.inf
    assert least_discovery(np.abs(rng.normal(size=5000)), 0.4) == np.inf
    assert least_discovery(np.full(50, 3.0), 0.4) == np.inf


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_no_more_ordinary_ones_pass_than_allowed_and_most_of_the_others_do(share):
    rng = np.random.default_rng(1)
    ordinary = rng.exponential(size=20_000)
    odd = rng.normal(9.0, 1.5, size=round(20_000 * share))
    cut = least_discovery(np.concatenate([ordinary, odd]), 0.2)
    passed, found = (ordinary >= cut).sum(), (odd >= cut).sum()
    assert passed / (passed + found) < 0.25
    assert found > 0.9 * len(odd)


def test_scores_that_are_all_alike_but_one_give_that_one():
    assert least_discovery(np.array([1.0] * 40 + [2.0]), 0.4) == 2.0


def test_the_fence_stands_off_by_quartile_ranges():
    assert far_fence(np.arange(101.0), 2.5) == 75 + 2.5 * 50
