"""k-NN and SVR: right answers, the estimator contract, batches, bad input."""

import numpy as np
import pytest
from sklearn.svm import SVR
from sklearn.utils.estimator_checks import check_estimator

from evastudio.errors import InvalidInputError
from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.local_linear import LocalLinearPolicy
from evastudio.learning.mlp import MLPPolicy
from evastudio.learning.quantized import QuantizedKNNPolicy, QuantizedSVRPolicy
from evastudio.learning.rival_cleaning import ClusterEliminator, ConflictBlender
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.learning.voting import VotingKNNPolicy

EXPECTED_FAILURES = {
    "check_fit_score_takes_y": "arguments are `states, actions`, the field's words, not X and y",
}
"""Of scikit-learn's own checks, with the reason; every other one passes or does not apply."""


ALL = [
    KNNPolicy(),
    KNNPolicy(weights="distance"),
    SVRPolicy(),
    SVRPolicy(bases=50),
    LocalLinearPolicy(k=5),
    SampledKNNPolicy(),
    MLPPolicy(8),
    VotingKNNPolicy(),
    VotingKNNPolicy(weights="distance"),
    QuantizedSVRPolicy(),
    QuantizedKNNPolicy(),
    ConflictEliminator(),
    ClusterEliminator(),
    ConflictBlender(),
]


@pytest.mark.parametrize("learner", ALL, ids=repr)
def test_learners_keep_the_estimator_contract(learner):
    results = check_estimator(
        learner, expected_failed_checks=EXPECTED_FAILURES, on_fail="raise", on_skip=None
    )
    failed = {one["check_name"] for one in results if one["status"] == "xfail"}
    assert failed == set(EXPECTED_FAILURES)
    assert sum(one["status"] == "passed" for one in results) > 25


def test_they_are_offered_by_the_room_itself():
    from evastudio.learning import (
        ConflictEliminator,
        KNNPolicy,
        LocalLinearPolicy,
        MLPPolicy,
        SampledKNNPolicy,
        SVRPolicy,
        VotingKNNPolicy,
        load_policy,
    )

    assert {ConflictEliminator, VotingKNNPolicy, SampledKNNPolicy} <= set(map(type, ALL))
    assert {KNNPolicy, SVRPolicy, LocalLinearPolicy, MLPPolicy} <= set(map(type, ALL))
    assert callable(load_policy)


def some_pairs(seed=0, count=200, outputs=2):
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(count, 3)) * [1.0, 50.0, 0.01] + [0.0, 7.0, 1.0]
    actions = np.stack([np.sin(states[:, 0]), states[:, 1] / 50, states[:, 2]], 1)[:, :outputs]
    return states, actions


@pytest.mark.parametrize("weights", ["uniform", "distance"])
def test_knn_is_the_mean_of_the_nearest(weights):
    states, actions = some_pairs()
    queries, _ = some_pairs(1, 30)
    scale, offset = states.std(axis=0), states.mean(axis=0)
    away = np.linalg.norm((queries[:, None] - states[None]) / scale, axis=2)
    assert offset.shape == (3,)
    near = np.argsort(away, axis=1)[:, :4]
    share = np.ones((30, 4)) if weights == "uniform" else 1 / np.take_along_axis(away, near, axis=1)
    wanted = (share[:, :, None] * actions[near]).sum(axis=1) / share.sum(axis=1, keepdims=True)
    answer = KNNPolicy(4, weights).fit(states, actions).predict(queries)
    # Distances are of float32 points, so weights by distance agree to about six digits.
    assert np.allclose(answer, wanted, rtol=1e-5, atol=1e-6)


def test_knn_weighed_by_distance_repeats_a_pair_it_has_seen():
    states, actions = some_pairs()
    assert np.array_equal(KNNPolicy(5, "distance").fit(states, actions).predict(states), actions)


def test_svr_agrees_with_scikit_learn():
    states, actions = some_pairs()
    queries, _ = some_pairs(1, 50)
    learner = SVRPolicy(C=10.0, epsilon=0.05, gamma=0.1).fit(states, actions)
    offset, scale = states.mean(axis=0), states.std(axis=0)
    for column in range(2):
        low, high = actions[:, column].min(), actions[:, column].max()
        middle, half = (low + high) / 2, (high - low) / 2
        peer = SVR(C=10.0, epsilon=0.05, gamma=0.1, cache_size=400)
        peer.fit((states - offset) / scale, (actions[:, column] - middle) / half)
        wanted = peer.predict((queries - offset) / scale) * half + middle
        away = np.abs(learner.predict(queries)[:, column] - wanted)
        assert away.max() < 2e-3 * half  # both stop within 1e-3 of the minimum


@pytest.mark.parametrize(
    "learner", [KNNPolicy(3), KNNPolicy(3, "distance"), SVRPolicy(), MLPPolicy()]
)
def test_the_answer_to_one_state_is_its_answer_in_any_batch(learner):
    states, actions = some_pairs()
    queries, _ = some_pairs(2, 600)
    learner.fit(states, actions)
    whole = learner.decide(queries)
    for rows in (slice(0, 1), slice(17, 18), slice(255, 258), slice(3, 600, 7)):
        assert np.array_equal(learner.decide(queries[rows]), whole[rows])


@pytest.mark.parametrize("learner", [KNNPolicy(3), SVRPolicy(), LocalLinearPolicy(9), MLPPolicy()])
def test_explanations_point_at_recorded_pairs(learner):
    states, actions = some_pairs()
    reasons = learner.fit(states, actions).explain(states[:9])
    assert reasons.pairs.shape == reasons.distances.shape
    assert reasons.pairs.max() < len(states)
    offset, scale = states.mean(axis=0), states.std(axis=0)
    named = (states[reasons.pairs[:, 0]] - states[:9]) / scale
    assert offset.shape == (3,)
    assert np.allclose(np.linalg.norm(named, axis=1), reasons.distances[:, 0], atol=1e-9)


def test_a_state_component_that_never_changes_does_no_harm():
    states, actions = some_pairs()
    states[:, 1] = 0.1
    for learner in (KNNPolicy(3), SVRPolicy(), MLPPolicy()):
        assert np.isfinite(learner.fit(states, actions).predict(states)).all()


@pytest.mark.parametrize(
    ("learner", "says"),
    [
        (KNNPolicy(0), "k is 0"),
        (KNNPolicy(2.5), "k is 2.5"),
        (KNNPolicy("five"), "k is 'five'"),
        (KNNPolicy(11), "only 10"),
        (KNNPolicy(3, "much"), "weights is 'much'"),
        (SVRPolicy(C=0.0), "C=0.0"),
        (SVRPolicy(gamma=float("nan")), "gamma=nan"),
        (SVRPolicy(epsilon="small"), "epsilon='small'"),
        (MLPPolicy(hidden=0), "hidden is 0"),
        (MLPPolicy(hidden=1e9), "hidden is 1000000000.0"),
        (MLPPolicy(seed="lucky"), "seed is 'lucky'"),
        (MLPPolicy(alpha=-1.0), "alpha=-1.0"),
    ],
)
def test_a_setting_that_means_nothing_is_named(learner, says):
    with pytest.raises(InvalidInputError, match=says):
        learner.fit(np.arange(10.0)[:, None], np.arange(10.0))


@pytest.mark.parametrize("learner", [KNNPolicy(2), SVRPolicy(), MLPPolicy()])
def test_pairs_that_cannot_be_used_are_refused(learner):
    good = np.arange(10.0)[:, None]
    for states, actions in (
        (np.zeros((0, 1)), np.zeros(0)),
        (good, np.zeros(9)),
        (np.where(good == 3, np.nan, good), np.zeros(10)),
        (good, np.where(good == 3, np.inf, good)),
    ):
        with pytest.raises(InvalidInputError, match="cannot be learned from"):
            learner.fit(states, actions)
    learner.fit(good, good)
    with pytest.raises(InvalidInputError, match="cannot be answered"):
        learner.predict(np.zeros((1, 2)))
