"""Conflict elimination against figure 2 written out by hand, and cases with known answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.learning.conflicts import ConflictEliminator, otsu


def figure_2(states, actions, count, threshold, span):
    """The paper's figure 2, one pair at a time, with the pair left out of its neighbours."""
    scaled = (states - states.mean(axis=0)) / states.std(axis=0)
    shares = actions / span
    marked = []
    for own in range(len(states)):
        away = [
            (np.linalg.norm(scaled[other] - scaled[own]), other) for other in range(len(states))
        ]
        near = [other for _, other in sorted(away) if other != own][:count]
        sums = [sum(np.linalg.norm(shares[i] - shares[j]) for j in near) for i in near]
        median = shares[near[int(np.argmin(sums))]]
        marked.append(np.linalg.norm(median - shares[own]) > threshold)
    return np.array(marked)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 3), st.sampled_from([1, 3, 5, 7, 9]))
def test_it_marks_what_figure_2_marks(seed, outputs, count):
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(40, 3))
    actions = rng.normal(size=(40, outputs))
    span = np.full(outputs, 4.0)
    found = ConflictEliminator(count, 0.3, span).fit(states, actions)
    assert found.conflict_mask_.tolist() == figure_2(states, actions, count, 0.3, span).tolist()


def test_one_contradiction_among_many_is_found_and_the_rest_is_kept():
    states = np.linspace(0.0, 1.0, 30)[:, None]
    actions = states.copy()
    actions[12] = -1.0
    kept_states, kept_actions = ConflictEliminator(5, 0.2).fit_resample(states, actions)
    assert len(kept_states) == len(kept_actions) == 29
    assert -1.0 not in kept_actions


def test_marked_pairs_still_testify_against_others():
    """All are tested against all: deletion comes as a batch, at the end."""
    states = np.arange(6.0)[:, None]
    actions = np.array([[0.0], [0.0], [0.0], [1.0], [1.0], [1.0]])
    found = ConflictEliminator(5, 0.5).fit(states, actions)
    assert found.conflict_mask_.all()


def test_a_pair_is_not_its_own_neighbour_even_among_equal_states():
    states = np.zeros((8, 2))
    actions = np.zeros((8, 1))
    actions[7] = 1.0
    found = ConflictEliminator(3, 0.5).fit(states, actions)
    assert found.conflict_mask_.tolist() == [False] * 7 + [True]


def test_the_threshold_is_a_share_of_the_range_of_each_component():
    rng = np.random.default_rng(0)
    states, actions = rng.normal(size=(60, 2)), rng.normal(size=(60, 2))
    one = ConflictEliminator(5, 0.2, [8.0, 8.0]).fit(states, actions)
    scaled = actions * [1.0, 1000.0]
    other = ConflictEliminator(5, 0.2, [8.0, 8000.0]).fit(states, scaled)
    assert one.conflict_mask_.tolist() == other.conflict_mask_.tolist()


def test_sample_indices_are_the_pairs_not_in_conflict():
    rng = np.random.default_rng(1)
    found = ConflictEliminator().fit(rng.normal(size=(50, 2)), rng.normal(size=50))
    assert np.array_equal(found.sample_indices_, np.flatnonzero(~found.conflict_mask_))


def test_otsu_parts_two_heaps():
    assert 0.2 < otsu(np.array([0.0, 0.1, 0.2, 0.15, 0.9, 1.0, 0.95])) < 0.9
    assert otsu(np.full(5, 0.3)) == 0.3


def test_the_threshold_can_be_found_automatically():
    rng = np.random.default_rng(2)
    states = rng.uniform(size=(300, 2))
    actions = states[:, :1] + rng.normal(scale=0.01, size=(300, 1))
    wrong = rng.choice(300, 12, replace=False)
    actions[wrong] += 3.0
    found = ConflictEliminator(9, "auto").fit(states, actions)
    assert set(np.flatnonzero(found.conflict_mask_)) == set(wrong)


@pytest.mark.parametrize(
    ("learner", "states", "actions", "says"),
    [
        (ConflictEliminator(), np.zeros((3, 1)), np.zeros(3), "at least 6"),
        (ConflictEliminator(), np.full((9, 1), np.nan), np.zeros(9), "NaN"),
        (ConflictEliminator(), np.zeros((9, 1)), np.zeros(8), "inconsistent"),
        (ConflictEliminator(n_neighbors=0), np.zeros((9, 1)), np.zeros(9), "n_neighbors=0"),
        (ConflictEliminator(n_neighbors=2.5), np.zeros((9, 1)), np.zeros(9), "whole number"),
        (ConflictEliminator(threshold=-1.0), np.zeros((9, 1)), np.zeros(9), "threshold=-1.0"),
        (ConflictEliminator(threshold="much"), np.zeros((9, 1)), np.zeros(9), "threshold='much'"),
        (ConflictEliminator(action_range=[1.0, 2.0]), np.zeros((9, 1)), np.zeros(9), "1 numbers"),
    ],
)
def test_bad_input_is_named(learner, states, actions, says):
    with pytest.raises(InvalidInputError, match=says):
        learner.fit(states, actions)
