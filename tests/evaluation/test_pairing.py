"""Two pilots on the same worlds: tests and intervals against published and library figures."""

import numpy as np
import pytest
from scipy import stats

from evastudio.errors import InvalidInputError
from evastudio.evaluation.interval import mean_interval
from evastudio.evaluation.pairing import compare_figures, compare_rates, holm


def worlds(both: int, won: int, lost: int, neither: int) -> tuple[np.ndarray, np.ndarray]:
    ours = np.repeat([True, True, False, False], [both, won, lost, neither])
    theirs = np.repeat([True, False, True, False], [both, won, lost, neither])
    return ours, theirs


@pytest.mark.parametrize(
    ("counts", "difference", "low", "high"),
    [
        # Altman, Machin, Bryant, Gardner, "Statistics with confidence", 2000, table 6.2
        ((14, 5, 0, 22), 0.122, 0.011, 0.226),
        # Fagerland, Lydersen, Laake, "Recommended tests and confidence intervals for paired
        # binomial proportions", 2014
        ((1, 1, 7, 12), -0.286, -0.507, -0.026),
        ((59, 6, 16, 80), -0.062, -0.119, -0.005),
    ],
)
def test_intervals_of_paired_rates_are_the_published_ones(counts, difference, low, high):
    found = compare_rates(*worlds(*counts))
    assert found.difference == pytest.approx(difference, abs=5e-4)
    assert found.interval == pytest.approx((low, high), abs=5e-4)


def test_the_exact_test_looks_at_the_worlds_that_just_one_succeeded_in():
    found = compare_rates(*worlds(59, 6, 16, 80))
    assert found.p == stats.binomtest(6, 22).pvalue
    assert found.effect == pytest.approx(-10 / 22)
    same = compare_rates(*worlds(30, 0, 0, 2))
    assert (same.difference, same.p, same.effect) == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(("worlds", "method"), [(80, "approx"), (20, "exact")])
def test_figures_are_compared_as_scipy_compares_them(worlds, method):
    rng = np.random.default_rng(5)
    ours, theirs = rng.normal(0.4, 1.0, worlds), rng.normal(0.0, 1.0, worlds)
    found = compare_figures(ours, theirs)
    assert found is not None
    assert found.difference == pytest.approx((ours - theirs).mean())
    assert found.p == stats.wilcoxon(ours, theirs, method=method).pvalue
    assert found.interval[0] < found.difference < found.interval[1]


def test_the_rank_biserial_correlation_is_the_share_of_ranks_won_less_lost():
    found = compare_figures(np.array([1.0, 2.0, -3.0]), np.zeros(3))
    assert found is not None
    assert found.effect == pytest.approx((1 + 2 - 3) / 6)


def test_worlds_without_a_figure_are_left_out():
    ours = np.array([1.0, np.nan, 3.0, np.inf, 5.0])
    found = compare_figures(ours, np.zeros(5))
    assert found is not None
    assert (found.worlds, found.difference) == (3, 3.0)
    assert compare_figures(np.array([np.nan, 1.0]), np.zeros(2)) is None


def test_figures_that_never_differ_have_no_effect():
    found = compare_figures(np.ones(5), np.ones(5))
    assert found is not None
    assert (found.difference, found.p, found.effect) == (0.0, 1.0, 0.0)


def test_different_worlds_cannot_be_paired():
    with pytest.raises(InvalidInputError, match="same worlds"):
        compare_rates(np.ones(3, dtype=bool), np.ones(4, dtype=bool))
    with pytest.raises(InvalidInputError, match="same worlds"):
        compare_figures(np.zeros(0), np.zeros(0))


def test_the_bootstrap_interval_of_a_mean_agrees_with_scipy():
    figures = np.random.default_rng(8).exponential(size=200)
    rng = np.random.default_rng(0)
    theirs = stats.bootstrap(
        (figures,), np.mean, method="percentile", n_resamples=5000, rng=rng
    ).confidence_interval
    assert mean_interval(figures) == pytest.approx((theirs.low, theirs.high), abs=0.02)
    assert mean_interval(figures) == mean_interval(figures)
    with pytest.raises(InvalidInputError, match="no figures"):
        mean_interval(np.zeros(0))


@pytest.mark.parametrize(
    ("p", "corrected"),
    [
        # p.adjust(p, "holm") of R 4.3
        ([0.01, 0.02, 0.03, 0.04, 0.05], [0.05, 0.08, 0.09, 0.09, 0.09]),
        ([0.01, 0.04, 0.03, 0.005], [0.03, 0.06, 0.06, 0.02]),
        ([0.6, 0.9], [1.0, 1.0]),
        ([0.04], [0.04]),
        ([], []),
    ],
)
def test_p_values_of_many_figures_are_corrected_as_r_does(p, corrected):
    assert holm(p) == pytest.approx(corrected)


def test_luck_alone_is_seldom_called_a_difference_however_many_are_compared():
    families = np.random.default_rng(3).uniform(size=(2000, 12))
    wrong = np.mean([min(holm(list(family))) < 0.05 for family in families])
    assert wrong == pytest.approx(0.05, abs=0.015)
    assert np.mean(families.min(axis=1) < 0.05) > 0.4
