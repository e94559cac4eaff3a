"""The SVR as a learner that goes on: pairs that come and go, compact forms, reasons."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning.dual import TOLERANCE, dual_slopes, dual_violation
from evastudio.learning.global_regressor import NEIGHBORS
from evastudio.learning.svr import MOST_BASES, SVRPolicy
from evastudio.world.spaces import Array


def pairs(seed: int, count: int = 300) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    states = rng.normal(size=(count, 3))
    actions = np.stack([np.sin(states[:, 0]), states[:, 1] * states[:, 2]], axis=1)
    return states, actions + rng.normal(0.0, 0.1, actions.shape)


def violation(policy: SVRPolicy) -> float:
    """How far `policy` is from the best fit to the pairs it keeps."""
    wanted = (policy.actions_ - policy.middle_) / policy.half_
    assert policy.duals_.sum(axis=0) == pytest.approx(0.0, abs=1e-9)
    assert np.abs(policy.duals_).max() <= policy.C
    return max(
        dual_violation(
            dual_slopes(policy.states_, wanted[:, column], duals, policy.gamma),
            duals,
            policy.C,
            policy.epsilon,
        )
        for column, duals in enumerate(policy.duals_.T)
    )


@pytest.mark.parametrize("C", [0.05, 30.0])
def test_adding_and_removing_ends_at_the_best_fit_to_the_pairs_that_are_left(C: float) -> None:  # noqa: N803
    states, actions = pairs(0)
    more_states, more_actions = pairs(2, 100)
    policy = SVRPolicy(C=C).fit(states, actions)
    offset = policy.offset_
    policy.add_pairs(more_states, more_actions)
    gone = np.r_[policy.support_[:40], 350]
    policy.remove_pairs(gone)
    kept = np.delete(np.concatenate([states, more_states]), gone, axis=0)
    wanted = np.delete(np.concatenate([actions, more_actions]), gone, axis=0)
    assert np.array_equal(policy.actions_, wanted)
    assert np.allclose(policy.states_ * policy.scale_ + policy.offset_, kept)
    assert policy.offset_ is offset
    assert violation(policy) <= 2.0 * TOLERANCE
    queries, _ = pairs(3, 50)
    anew = deepcopy(policy)
    anew._settle(anew.states_, anew.actions_, None)
    apart = np.abs(anew.prepare().decide(queries) - policy.decide(queries)) / policy.half_
    assert apart.max() < 0.02  # both within the solver's tolerance of the minimum


def test_removing_one_pair_changes_what_is_done_there() -> None:
    """A mistake is taken back, and the behaviour follows at once."""
    states = np.linspace(-1.0, 1.0, 41)[:, None]
    actions = np.zeros(41)
    actions[20] = 1.0
    policy = SVRPolicy(C=100.0, epsilon=0.05, gamma=300.0).fit(states, actions)
    assert policy.predict([[0.0]])[0] > 0.9
    named = policy.explain([[0.0]]).pairs[0, 0]
    assert named == 20
    assert policy.remove_pairs([named]).predict([[0.0]])[0] < 0.1


def test_all_but_one_pair_can_go() -> None:
    policy = SVRPolicy().fit(*pairs(0, 20))
    policy.remove_pairs(range(19))
    assert np.isfinite(policy.predict([[0.0, 0.0, 0.0]])).all()
    with pytest.raises(InvalidInputError, match="leaves none"):
        policy.remove_pairs([0])


def test_a_compact_form_says_that_it_keeps_no_pairs() -> None:
    states, actions = pairs(0)
    whole = SVRPolicy().fit(states, actions)
    for compact in (SVRPolicy(bases=20).fit(states, actions), whole.compact(states, 20)):
        for change in (
            lambda one=compact: one.add_pairs(states, actions),
            lambda one=compact: one.remove_pairs([0]),
        ):
            with pytest.raises(InvalidInputError, match="keeps no demonstrations"):
                change()
        assert len(compact.kept) == len(compact.coefficients_) <= 20
    assert len(whole.kept) == 300


def test_reasons_are_the_nearest_demonstrations_and_whether_they_agree() -> None:
    states, _ = pairs(0)
    side = np.where(np.random.default_rng(1).random(300) < 0.5, -1.0, 1.0)
    # Agreed upon where the first component is negative, contradicting each other where not.
    policy = SVRPolicy().fit(states, np.where(states[:, 0] < 0.0, -1.0, side))
    reasons = policy.explain(states)
    assert np.array_equal(reasons.pairs[:, 0], np.arange(300))
    assert reasons.pairs.shape == (300, NEIGHBORS)
    assert reasons.weights.sum(axis=1) == pytest.approx(1.0)
    assert (np.diff(reasons.weights, axis=1) <= 0.0).all()
    assert reasons.agreement is not None
    sure, torn = reasons.agreement[states[:, 0] < -0.7], reasons.agreement[states[:, 0] > 0.7]
    assert sure == pytest.approx(1.0)
    assert torn.mean() < 0.4
    assert policy.compact(states, 20).explain(states).agreement is None


@pytest.mark.parametrize("bases", [0, 2.5, "few", MOST_BASES + 1, float("nan")])
def test_a_number_of_bases_that_means_nothing_is_refused(bases: object) -> None:
    with pytest.raises(InvalidInputError, match="bases is"):
        SVRPolicy(bases=bases).fit(*pairs(0, 20))  # type: ignore[arg-type]
