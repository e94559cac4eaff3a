"""How alike two ways of moving are."""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.distance import cdist

from evastudio.errors import InvalidInputError
from evastudio.evaluation.likeness import MOST, inhomogeneity, thinned


def test_in_one_dimension_it_is_scipys_energy_distance_made_dimensionless():
    rng = np.random.default_rng(1)
    ours, theirs = rng.normal(0.3, 1.0, (200, 1)), rng.normal(0.0, 2.0, (150, 1))
    scaled = ours / theirs.std(), theirs / theirs.std()
    squared = stats.energy_distance(scaled[0][:, 0], scaled[1][:, 0]) ** 2
    between = 2.0 * cdist(*scaled).mean()
    assert inhomogeneity(ours, theirs) == pytest.approx(squared / between)


def test_the_same_moments_are_not_apart_and_separate_ones_wholly():
    rng = np.random.default_rng(2)
    moments = rng.normal(size=(300, 4))
    assert inhomogeneity(moments, moments) == pytest.approx(0.0, abs=1e-12)
    assert inhomogeneity(moments + 1e6, moments) == pytest.approx(1.0, abs=1e-5)


def test_units_do_not_matter():
    rng = np.random.default_rng(3)
    ours, theirs = rng.normal(0.5, 1.0, (90, 3)), rng.normal(size=(80, 3))
    units = np.array([1.0, 1000.0, 1e-3])
    assert inhomogeneity(ours * units, theirs * units) == pytest.approx(inhomogeneity(ours, theirs))


def test_of_many_moments_evenly_spaced_ones_are_compared():
    moments = np.arange(10_000.0)[:, None]
    kept = thinned(moments)
    assert len(kept) == MOST
    assert (kept[0], kept[-1]) == (0.0, 9999.0)
    assert np.ptp(np.diff(kept[:, 0])) <= 1.0


def test_samples_that_cannot_be_compared_are_refused():
    with pytest.raises(InvalidInputError, match="cannot be compared"):
        inhomogeneity(np.zeros((0, 2)), np.zeros((5, 2)))
    with pytest.raises(InvalidInputError, match="cannot be compared"):
        inhomogeneity(np.zeros((5, 3)), np.zeros((5, 2)))
