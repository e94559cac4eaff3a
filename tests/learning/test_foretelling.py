import numpy as np
import pytest

from evastudio.learning.foretelling import COMPONENTS, foretold
from evastudio.learning.holdout import take_folds

ONE = np.ones(1)


@pytest.fixture
def takes():
    return np.repeat(np.arange(6), 80)


def test_a_curve_of_the_second_degree_is_told_almost_exactly(takes):
    given = np.random.default_rng(0).normal(size=(len(takes), 3))
    wanted = (1.0 + given[:, 0] * given[:, 1] - given[:, 2] ** 2)[:, None]
    assert foretold(given, wanted, take_folds(takes), ONE).mean() < 1e-3 * wanted.var()


def test_nothing_given_tells_the_mean_of_the_other_takes(takes):
    wanted = np.random.default_rng(0).normal(size=(len(takes), 1))
    folds = take_folds(takes)
    wrong = foretold(np.empty((len(takes), 0)), wanted, folds, ONE)
    for held in folds:
        assert wrong[held] == pytest.approx((wanted[held, 0] - wanted[~held].mean()) ** 2)


def test_a_take_that_is_held_out_teaches_nothing(takes):
    """The given tell the take, and each take has an action of its own."""
    rng = np.random.default_rng(0)
    given, own = rng.normal(size=(6, 2))[takes], rng.normal(size=(6, 1))[takes]
    assert foretold(given, own, take_folds(takes, 6), ONE).mean() > 0.5


def test_constant_and_very_wide_givens_are_no_trouble(takes):
    rng = np.random.default_rng(0)
    hidden = rng.normal(size=(len(takes), 2))
    given = hidden @ rng.normal(size=(2, 3 * COMPONENTS))
    given[:, 5] = 7.0
    wrong = foretold(given, hidden[:, :1], take_folds(takes), ONE)
    assert np.isfinite(wrong).all()
    assert wrong.mean() < 0.01
