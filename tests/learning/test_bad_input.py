"""Whatever a learner is given, it answers rightly or says in a sentence what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.local_linear import LocalLinearPolicy
from evastudio.learning.mlp import MLPPolicy
from evastudio.learning.sampled import SampledKNNPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.learning.voting import VotingKNNPolicy
from evastudio.world.spaces import Array

RNG = np.random.default_rng(0)
STATES = RNG.normal(size=(60, 3))
ACTIONS = np.sin(STATES[:, :2])
LEARNERS = [
    KNNPolicy(1),
    KNNPolicy(1, "distance"),
    LocalLinearPolicy(1),
    SampledKNNPolicy(1),
    VotingKNNPolicy(1),
    SVRPolicy(),
    SVRPolicy(bases=8),
    MLPPolicy(4),
]
EVERY = pytest.mark.parametrize("learner", LEARNERS, ids=repr)


def taught(learner: Any, states: Any, actions: Array, k: int | None = None) -> Any:
    """`learner` fitted, to symbols where it learns these; with `k` where it has one."""
    if k is not None and "k" in learner.get_params():
        learner = type(learner)(k)
    if isinstance(learner, VotingKNNPolicy):
        return learner.fit(states, (actions[:, 0] > 0.0).astype(int))
    return learner.fit(states, actions)


@EVERY
@pytest.mark.parametrize(
    ("states", "actions", "k"),
    [
        (STATES[:1], ACTIONS[:1], 1),
        (np.ones((40, 3)), np.full((40, 2), 0.3), 7),
        (STATES, np.full((60, 2), -0.2), 7),
        (STATES * 1e-300, ACTIONS * 1e-300, 7),
        (STATES * 1e-6 + 1e12, ACTIONS, 7),
        (STATES * 1e29, ACTIONS * 1e29, 7),
        (STATES[:, :1] * [1.0, 0.0], ACTIONS, 60),
        (RNG.normal(size=(70, 10_000)), RNG.normal(size=(70, 2)), 60),
    ],
    ids=["one", "same", "no-range", "tiny", "far", "huge", "k-is-all", "10000-features"],
)
def test_odd_pairs_are_learned(learner: Any, states: Array, actions: Array, k: int) -> None:
    policy = taught(learner, states, actions, k)
    answers = policy.predict(states)
    assert len(answers) == len(states)
    assert np.isfinite(answers).all()
    if np.ptp(actions, axis=0).max() == 0.0 and not isinstance(learner, VotingKNNPolicy):
        assert answers == pytest.approx(actions)
    reasons = policy.explain(states)
    assert np.isfinite(reasons.distances).all()
    assert reasons.weights.sum(axis=1) == pytest.approx(1.0)
    assert reasons.agreement is None or np.isfinite(reasons.agreement).all()


@EVERY
@pytest.mark.parametrize(
    ("states", "says"),
    [
        (STATES[:0], "0 sample"),
        (np.zeros((60, 0)), "0 feature"),
        (np.zeros((60, 3, 2)), "dim 3"),
        (STATES[:59], "inconsistent numbers of samples"),
        (np.where(STATES > 2.0, np.nan, STATES), "NaN"),
        (np.where(STATES > 2.0, np.inf, STATES), "infinity"),
        (np.full((60, 3), "far"), "convert string"),
        (STATES * 1e150, "Give them in another unit"),
    ],
)
def test_pairs_that_cannot_be_learned_are_refused(learner: Any, states: Any, says: str) -> None:
    actions = ACTIONS[: len(states)] if len(states) != 59 else ACTIONS
    with pytest.raises(InvalidInputError, match=says):
        taught(learner, states, actions)


@EVERY
@pytest.mark.parametrize("wrong", [np.full((1, 3), np.nan), np.zeros((1, 4)), np.zeros(3)])
def test_states_that_cannot_be_answered_are_refused(learner: Any, wrong: Array) -> None:
    policy = taught(learner, STATES, ACTIONS)
    for ask in (policy.predict, policy.explain):
        with pytest.raises(InvalidInputError, match="cannot be answered"):
            ask(wrong)


@EVERY
def test_states_beyond_all_that_was_shown_are_answered(learner: Any) -> None:
    policy = taught(learner, STATES, ACTIONS, 7)
    for far in (1e6, -1e15, 1e30):
        assert np.isfinite(policy.predict(np.full((2, 3), far))).all()


@pytest.mark.parametrize("learner", LEARNERS[:5], ids=repr)
def test_a_k_that_cannot_be_is_refused(learner: Any) -> None:
    for k in (0, -1, 2.5, "five", float("nan"), 61, 10**30):
        with pytest.raises(InvalidInputError, match=r"k is|only 60"):
            taught(learner, STATES, ACTIONS, k)  # type: ignore[arg-type]
