import numpy as np
import pytest
from sklearn.dummy import DummyRegressor
from sklearn.linear_model import LinearRegression

from evastudio.errors import InvalidInputError
from evastudio.learning import KNNPolicy, VotingKNNPolicy, holdout
from evastudio.learning.holdout import hold_out, take_folds


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def some_takes(rng, count=6, pairs=40):
    takes = np.repeat(np.arange(count) * 10, pairs)
    states = rng.normal(size=(len(takes), 3))
    actions = states @ np.array([[1.0, 0.0], [0.5, -2.0], [0.0, 30.0]])
    return states, actions, takes


def test_every_take_is_held_out_whole_and_once(rng):
    takes = rng.permutation(np.repeat([3, 5, 8, 9], [10, 20, 30, 40]))
    folds = take_folds(takes, 3)
    assert len(folds) == 3
    assert (np.sum(folds, axis=0) == 1).all()
    for take in np.unique(takes):
        assert sum(fold[takes == take].any() for fold in folds) == 1


def test_groups_hold_about_as_many_pairs_each():
    takes = np.repeat(np.arange(7), [60, 10, 10, 10, 10, 10, 10])
    assert sorted(int(fold.sum()) for fold in take_folds(takes, 2)) == [60, 60]


def test_one_take_cannot_be_held_out():
    with pytest.raises(InvalidInputError, match="only one take"):
        take_folds(np.zeros(50, dtype=np.int64))


def test_a_constant_errs_by_about_one_and_the_true_map_by_nothing(rng):
    states, actions, takes = some_takes(rng)
    assert hold_out(DummyRegressor(), states, actions, takes).error == pytest.approx(1.0, abs=0.05)
    found = hold_out(LinearRegression(), states, actions, takes)
    assert found.error < 1e-12
    assert set(found.by_take) == set(takes)


def test_frames_of_the_held_out_take_teach_nothing(rng):
    """Each take has an action of its own that only its frames could tell."""
    takes = np.repeat(np.arange(4), 30)
    states = np.repeat(rng.normal(size=(4, 2)), 30, axis=0)
    actions = np.repeat(rng.normal(size=4), 30)
    assert hold_out(KNNPolicy(k=3), states, actions, takes).error > 0.3


def test_pairs_left_out_of_learning_are_still_asked(rng):
    states, actions, takes = some_takes(rng)
    spoilt = actions.copy()
    bad = rng.random(len(takes)) < 0.2
    spoilt[bad] += 300.0
    every = hold_out(KNNPolicy(k=3), states, spoilt, takes)
    cleaned = hold_out(KNNPolicy(k=3), states, spoilt, takes, used=~bad)
    assert cleaned.error < every.error
    assert cleaned.error > 0.5


def test_symbols_count_the_share_of_wrong_ones(rng):
    takes = np.repeat(np.arange(4), 50)
    states = rng.normal(size=(200, 2))
    symbols = (states[:, 0] > 0).astype(float)
    wrong = rng.random(200) < 0.25
    symbols[wrong] = 1 - symbols[wrong]
    found = hold_out(VotingKNNPolicy(k=15), states, symbols, takes)
    assert 0.1 < found.error < 0.45


def test_a_component_that_never_changes_is_not_judged_by_rounding(rng):
    states = rng.normal(size=(60, 2))
    actions = np.stack([states[:, 0], np.full(60, 0.3)], axis=1)
    takes = np.repeat([0, 1, 2], 20)
    with_it = hold_out(KNNPolicy(k=3), states, actions, takes).error
    alone = hold_out(KNNPolicy(k=3), states, actions[:, 0], takes).error
    assert with_it == pytest.approx(alone / np.sqrt(2))


def test_of_very_many_pairs_every_so_many_takes_are_looked_at():
    takes = np.repeat(np.arange(12), 100)
    assert holdout.some_takes(takes, 1200).tolist() == list(range(12))
    assert holdout.some_takes(takes, 400).tolist() == [0, 3, 6, 9]
    assert len(holdout.some_takes(takes, 100)) == 12  # one take alone would tell little
