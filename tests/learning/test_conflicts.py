"""Conflict elimination against figure 2 written out by hand, and cases with known answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.learning.conflicts import ConflictEliminator


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


def test_the_threshold_can_be_found_automatically():
    rng = np.random.default_rng(2)
    states = rng.uniform(size=(300, 2))
    actions = states[:, :1] + rng.normal(scale=0.01, size=(300, 1))
    wrong = rng.choice(300, 12, replace=False)
    actions[wrong] += 3.0
    found = ConflictEliminator(9, "auto").fit(states, actions)
    assert set(np.flatnonzero(found.conflict_mask_)) == set(wrong)


def wavy(rng, count=1500, noise=0.03):
    """Smooth actions of two components, a little shaky everywhere."""
    states = rng.uniform(-2, 2, size=(count, 3))
    actions = np.stack([np.sin(states[:, 0]), np.cos(states[:, 1])], axis=1)
    return states, actions + rng.normal(scale=noise, size=actions.shape)


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05, 0.2])
def test_automatically_next_to_nothing_is_found_where_there_is_nothing(noise):
    found = ConflictEliminator(25, "auto").fit(*wavy(np.random.default_rng(3), noise=noise))
    assert found.conflict_mask_.mean() < 0.01


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_automatically_few_and_many_conflicts_are_found(share, noise):
    rng = np.random.default_rng(4)
    states, actions = wavy(rng, noise=noise)
    wrong = rng.choice(len(states), round(share * len(states)), replace=False)
    angle = rng.uniform(0, 2 * np.pi, len(wrong))
    actions[wrong] += 1.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    marked = np.flatnonzero(ConflictEliminator(25, "auto").fit(states, actions).conflict_mask_)
    assert np.isin(wrong, marked).mean() > 0.95
    assert np.isin(marked, wrong).mean() > 0.6


def test_more_is_asked_of_a_pair_where_the_others_differ_too():
    """The right half is shaky, the left is not; the same deviation is a conflict only left."""
    rng = np.random.default_rng(5)
    states = rng.uniform(-1, 1, size=(2000, 2))
    actions = rng.normal(size=2000) * np.where(states[:, 0] > 0, 0.3, 0.02)
    odd = [int(np.argmin(np.hypot(states[:, 0] - at, states[:, 1]))) for at in (-0.5, 0.5)]
    actions[odd] = 0.6
    found = ConflictEliminator(25, "auto", [2.0]).fit(states, actions)
    assert found.conflict_mask_[odd].tolist() == [True, False]
    assert found.limits_[odd[0]] < found.limits_[odd[1]]


def test_a_mistake_that_lasts_is_found_once_its_moments_do_not_count_as_neighbours():
    moments = np.concatenate([np.arange(200), np.arange(200) + 10_000])
    states = np.stack([moments % 10_000, moments >= 10_000], axis=1) * 1.0
    actions = np.zeros(400)
    actions[50:58] = 1.0
    alone = ConflictEliminator(5, 0.4, [2.0], gap=9)
    assert alone.fit(states, actions).conflict_mask_[50:58].sum() < 8
    told = alone.fit(states, actions, moments).conflict_mask_
    assert told[50:58].all()
    assert not told[200:].any()


def test_the_report_gives_the_neighbours_and_their_median():
    rng = np.random.default_rng(7)
    states, actions = wavy(rng, 300)
    actions[17] = [-3.0, 3.0]
    found = ConflictEliminator(9, 0.4).fit(states, actions)
    report = {conflict.pair: conflict for conflict in found.explain()}
    assert sorted(report) == np.flatnonzero(found.conflict_mask_).tolist()
    one = report[17]
    scaled = (states - states.mean(axis=0)) / states.std(axis=0)
    away = np.linalg.norm(scaled - scaled[17], axis=1)
    assert one.neighbors.tolist() == np.argsort(away)[1:10].tolist()
    assert any(np.allclose(one.median, actions[near]) for near in one.neighbors)
    apart = np.linalg.norm((actions[17] - one.median) / found.range_)
    assert one.deviation == pytest.approx(apart)
    assert one.deviation > one.limit == 0.4
    assert [conflict.pair for conflict in found.explain([3, 1])] == [1, 3]
    with pytest.raises(InvalidInputError, match="300 pairs"):
        found.explain([300])


def milling(rng, count=3000):
    """A crowd's walk: straight on, but for a rare turn where something stands ahead."""
    states = rng.uniform(0, 1, size=(count, 3))
    symbols = np.full(count, "ahead", dtype="<U5")
    near = states[:, 0] < 0.08
    symbols[near] = np.where(states[near, 1] < 0.5, "left", "right")
    idle = near & (rng.uniform(size=count) < 0.3)
    symbols[idle] = "ahead"
    return states, symbols


def test_rare_turns_survive_and_wrong_symbols_are_found():
    rng = np.random.default_rng(8)
    states, symbols = milling(rng)
    plain = ConflictEliminator(25, 0.1).fit(states, (symbols == "left") * 1.0)
    shown = symbols.copy()
    wrong = rng.choice(len(states), 90, replace=False)
    shown[wrong] = rng.choice(["ahead", "left", "right"], 90)
    wrong = wrong[shown[wrong] != symbols[wrong]]
    found = ConflictEliminator(25, "auto", symbols=True).fit(states, shown)
    turns = np.flatnonzero((symbols != "ahead") & (shown == symbols))
    assert found.conflict_mask_[turns].mean() < 0.05 < plain.conflict_mask_[turns].mean()
    assert found.conflict_mask_[wrong].mean() > 0.8
    assert found.conflict_mask_.mean() < 0.05
    assert {str(conflict.median[0]) for conflict in found.explain()} <= {"ahead", "left", "right"}


def test_symbols_may_be_numbers_and_their_order_does_not_matter():
    states, symbols = milling(np.random.default_rng(9), 500)
    eliminator = ConflictEliminator(15, "auto", symbols=True)
    named = eliminator.fit(states, symbols).conflict_mask_
    codes = np.select([symbols == "left", symbols == "right"], [7, -2], 3)
    assert np.array_equal(eliminator.fit(states, codes).conflict_mask_, named)
    kept, left = eliminator.fit_resample(states, symbols)
    assert len(kept) == len(left) == (~named).sum()
    assert left.dtype == symbols.dtype


@pytest.mark.parametrize(
    ("learner", "states", "actions", "says"),
    [
        (ConflictEliminator(), np.zeros((3, 1)), np.zeros(3), "at least 6"),
        (ConflictEliminator(), np.full((9, 1), np.nan), np.zeros(9), "NaN"),
        (ConflictEliminator(), np.zeros((9, 1)), np.zeros(8), "inconsistent"),
        (ConflictEliminator(n_neighbors=0), np.zeros((9, 1)), np.zeros(9), "n_neighbors=0"),
        (ConflictEliminator(n_neighbors=2.5), np.zeros((9, 1)), np.zeros(9), "whole number"),
        (ConflictEliminator(gap=0.5), np.zeros((9, 1)), np.zeros(9), "gap is 0.5"),
        (ConflictEliminator(gap=-1), np.zeros((9, 1)), np.zeros(9), "gap of 0 or more"),
        (ConflictEliminator(threshold=-1.0), np.zeros((9, 1)), np.zeros(9), "threshold=-1.0"),
        (ConflictEliminator(threshold="much"), np.zeros((9, 1)), np.zeros(9), "threshold='much'"),
        (ConflictEliminator(action_range=[1.0, 2.0]), np.zeros((9, 1)), np.zeros(9), "1 numbers"),
    ],
)
def test_bad_input_is_named(learner, states, actions, says):
    with pytest.raises(InvalidInputError, match=says):
        learner.fit(states, actions)
