"""Learners that keep their pairs: votes, samples, local lines, pairs that come and go, reasons."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sklearn.neighbors import KNeighborsClassifier

from evastudio.errors import InvalidInputError
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.local_linear import LocalLinearPolicy
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.voting import VotingKNNPolicy
from evastudio.world.spaces import Array

CONTINUOUS = [
    KNNPolicy(4),
    KNNPolicy(4, "distance"),
    LocalLinearPolicy(12),
    SampledKNNPolicy(5),
]


def pairs(seed: int, count: int = 300) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(count, 3))
    actions = np.stack([np.sin(states[:, 0]), states[:, 1] * states[:, 2]], axis=1)
    return states, actions


@pytest.mark.parametrize("learner", CONTINUOUS, ids=repr)
def test_one_state_is_answered_as_in_any_batch(learner: Any) -> None:
    learner.fit(*pairs(0))
    queries, _ = pairs(1, 1200)
    together = learner.decide(queries)
    for row in (0, 1, 600, 1199):
        assert np.array_equal(learner.decide(queries[row : row + 1])[0], together[row])


@pytest.mark.parametrize("learner", CONTINUOUS, ids=repr)
def test_adding_and_removing_pairs_is_as_fitting_with_the_same_scaling(learner: Any) -> None:
    states, actions = pairs(0)
    more_states, more_actions = pairs(2, 700)
    learner.fit(states, actions).add_pairs(more_states, more_actions)
    gone = np.arange(0, 1000, 3)
    learner.remove_pairs(gone)
    kept = np.delete(np.concatenate([states, more_states]), gone, axis=0)
    wanted = np.delete(np.concatenate([actions, more_actions]), gone, axis=0)
    assert np.array_equal(learner.actions_, wanted)
    assert np.allclose(learner.states_ * learner.scale_ + learner.offset_, kept)
    queries, _ = pairs(3, 50)
    changed = learner.decide(queries)
    assert np.array_equal(changed, learner.prepare().decide(queries))
    assert np.array_equal(changed, learner.prepare("plain").decide(queries))


def test_votes_are_scikit_learns() -> None:
    states, _ = pairs(0)
    symbols = np.array(["left", "right", "stand"])[
        (states[:, 0] > 0).astype(int) + (states[:, 1] > 1)
    ]
    queries, _ = pairs(1, 200)
    scaled = (states - states.mean(axis=0)) / states.std(axis=0)
    asked = (queries - states.mean(axis=0)) / states.std(axis=0)
    for weights in ("uniform", "distance"):
        ours = VotingKNNPolicy(5, weights).fit(states, symbols)
        peer = KNeighborsClassifier(5, weights=weights).fit(scaled, symbols)
        assert np.array_equal(ours.predict(queries), peer.predict(asked))
        assert ours.predict_proba(queries) == pytest.approx(peer.predict_proba(asked), abs=1e-5)
    codes = ours.decide(queries)
    assert codes.shape == (200, 1)
    assert np.array_equal(ours.classes_[codes[:, 0].astype(int)], ours.predict(queries))
    with pytest.raises(InvalidInputError, match="'jump' was not among"):
        ours.add_pairs(states[:1], ["jump"])


def test_samples_come_from_the_modes_as_often_as_these_were_shown() -> None:
    """Dodging left in a third of the pairs and right in the others: never straight ahead."""
    rng = np.random.default_rng(0)
    states = rng.normal(size=(600, 2))
    side = np.where(rng.random(600) < 1 / 3, -1.0, 1.0)
    actions = (side + rng.normal(0.0, 0.02, 600))[:, None]
    policy = SampledKNNPolicy(15).fit(states, actions)
    draws = rng.random(4000)
    decided = policy.decide(rng.normal(size=(4000, 2)), draws)[:, 0]
    assert (np.abs(np.abs(decided) - 1.0) < 0.1).all()
    assert abs((decided < 0).mean() - 1 / 3) < 0.05
    often = policy.decide(rng.normal(size=(500, 2)))[:, 0]
    assert (often > 0).mean() > 0.85


def test_a_local_line_follows_a_slope_that_a_mean_flattens() -> None:
    rng = np.random.default_rng(0)
    states = rng.uniform(-1.0, 1.0, size=(400, 2))
    actions = states @ np.array([[1.0], [-2.0]]) + 0.5
    queries = rng.uniform(-0.7, 0.7, size=(100, 2))
    wanted = queries @ np.array([[1.0], [-2.0]]) + 0.5
    line = np.abs(LocalLinearPolicy(20, 1e-6).fit(states, actions).predict(queries) - wanted)
    mean = np.abs(KNNPolicy(20).fit(states, actions).predict(queries) - wanted)
    assert line.max() < 1e-4
    assert mean.mean() > 10 * line.mean()


def test_identical_pairs_and_constant_actions_are_borne() -> None:
    states, actions = np.ones((30, 2)), np.full((30, 1), 0.25)
    for learner in (LocalLinearPolicy(10), SampledKNNPolicy(), KNNPolicy(5, "distance")):
        assert learner.fit(states, actions).predict(states) == pytest.approx(0.25)


@pytest.mark.parametrize("learner", CONTINUOUS, ids=repr)
def test_reasons_name_pairs_weights_and_agreement(learner: Any) -> None:
    states, actions = pairs(0)
    reasons = learner.fit(states, actions).explain(states[:20])
    assert np.array_equal(reasons.pairs[:, 0], np.arange(20))
    assert reasons.distances[:, 0] == pytest.approx(0.0)
    assert reasons.weights.sum(axis=1) == pytest.approx(1.0)
    assert ((reasons.agreement >= 0.0) & (reasons.agreement <= 1.0)).all()
    same = learner.fit(states, np.ones((300, 1))).explain(states[:5])
    assert same.agreement == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda p: p.remove_pairs([300]), "numbered from 0 to 299"),
        (lambda p: p.remove_pairs([-1]), "numbered from 0 to 299"),
        (lambda p: p.remove_pairs([0.5]), "no indices"),
        (lambda p: p.remove_pairs(range(299)), "fewer than the k=4"),
        (lambda p: p.add_pairs(np.zeros((2, 3)), np.zeros((1, 2))), "every state needs one action"),
        (lambda p: p.add_pairs(np.zeros((1, 4)), np.zeros((1, 2))), "features"),
        (lambda p: p.add_pairs(np.zeros((1, 3)), np.full((1, 2), np.nan)), "NaN"),
    ],
)
def test_pairs_that_cannot_come_or_go_are_refused(call: Any, says: str) -> None:
    policy = KNNPolicy(4).fit(*pairs(0))
    with pytest.raises(InvalidInputError, match=says):
        call(policy)
    assert len(policy.states_) == 300
