"""The compiled SVR solver, its decisions and the compact form, held against plain ones."""

import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from safetensors.numpy import load_file
from sklearn.exceptions import ConvergenceWarning

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.learning import dual
from evastudio.learning.bumps import Bumps
from evastudio.learning.compact import choose_bases
from evastudio.learning.dual import TOLERANCE, dual_slopes, dual_violation, solve_dual
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy_files import load_policy, save_policy
from evastudio.learning.scaling import Scaling
from evastudio.learning.svr import SVRPolicy


def some_problem(count, size=3, seed=0, outputs=2, noise=0.1):
    """Points about the origin and wavy targets from about -1 to 1, a little rough."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, size))
    waves = np.sin(points @ rng.normal(size=(size, outputs)))
    return points, waves + noise * rng.normal(size=(count, outputs))


def assert_both_agree(points, targets, **settings):
    ours = solve_dual(points, targets, **settings)
    theirs = solve_dual(points, targets, **settings, plain=True)
    for output, column in enumerate(targets.T):
        beta = ours.weights[:, output]
        slopes = dual_slopes(points, column, beta, settings["gamma"])
        left = dual_violation(slopes, beta, settings["C"], settings["epsilon"])
        assert left < TOLERANCE + 1e-6 * settings["C"]  # float32 kernels
        assert abs(beta.sum()) < 1e-9 * (1.0 + settings["C"])
        assert np.abs(beta).max() <= settings["C"]
    away = np.abs(ours.objectives - theirs.objectives)
    assert (away <= 1e-4 * np.abs(theirs.objectives) + 1e-6).all()
    assert np.abs(ours.intercepts - theirs.intercepts).max() < 20 * TOLERANCE + 1e-9
    return ours


@settings(max_examples=60, deadline=None)
@given(
    count=st.integers(1, 90),
    size=st.integers(1, 9),
    seed=st.integers(0, 10**6),
    cost=st.sampled_from([1e-3, 0.3, 1.0, 10.0, 100.0]),
    epsilon=st.sampled_from([0.01, 0.1, 0.5, 3.0]),
    gamma=st.sampled_from([0.01, 0.1, 1.0, 20.0]),
    twice=st.booleans(),
)
def test_the_minimum_is_that_of_scikit_learn(count, size, seed, cost, epsilon, gamma, twice):
    points, targets = some_problem(count, size, seed)
    if twice:  # the same states again, with other actions
        points = np.vstack([points, points])
        targets = np.vstack([targets, -0.5 * targets])
    solution = solve_dual(points, targets, C=cost, epsilon=epsilon, gamma=gamma)
    peer = solve_dual(points, targets, C=cost, epsilon=epsilon, gamma=gamma, plain=True)
    # Both may stop a tolerance early for each unit of weight.
    room = 1e-4 * np.abs(peer.objectives) + 0.1 * TOLERANCE * cost
    assert (np.abs(solution.objectives - peer.objectives) <= room).all()
    for output, column in enumerate(targets.T):
        beta = solution.weights[:, output]
        slopes = dual_slopes(points, column, beta, gamma)
        assert dual_violation(slopes, beta, cost, epsilon) < 1.1 * TOLERANCE + 1e-6 * cost
        assert abs(beta.sum()) < 1e-9 * (1.0 + cost)
        assert np.abs(beta).max() <= cost


@pytest.mark.parametrize("cost", [1.0, 30.0])
@pytest.mark.parametrize("gamma", [0.01, 0.3])
def test_thousands_of_pairs_agree_with_scikit_learn(cost, gamma):
    points, targets = some_problem(1500, 6)
    assert_both_agree(points, targets, C=cost, epsilon=0.1, gamma=gamma)


def test_identical_points_agree_with_scikit_learn():
    points = np.ones((40, 3))
    targets = np.linspace(-1, 1, 40)[:, None]
    solution = solve_dual(points, targets, C=2.0, epsilon=0.1, gamma=1.0)
    peer = solve_dual(points, targets, C=2.0, epsilon=0.1, gamma=1.0, plain=True)
    assert np.allclose(solution.objectives, peer.objectives, rtol=1e-4)


def test_targets_within_epsilon_need_no_support_vectors():
    points, targets = some_problem(50)
    for flat in (np.full_like(targets, 0.3), targets):
        solution = solve_dual(points, flat, C=1.0, epsilon=5.0, gamma=0.1)
        assert not solution.weights.any()
        middle = (flat.max(axis=0) + flat.min(axis=0)) / 2
        assert np.allclose(solution.intercepts, middle)


def test_one_pair_is_answered_by_its_own_action():
    solution = solve_dual(np.ones((1, 4)), np.array([[0.7, -2.0]]), C=1.0, epsilon=0.1, gamma=1.0)
    assert np.allclose(solution.intercepts, [0.7, -2.0])
    assert not solution.weights.any()


def test_little_memory_gives_the_same_minimum():
    points, targets = some_problem(600, 4)
    asked = {"C": 3.0, "epsilon": 0.05, "gamma": 0.3}
    much = solve_dual(points, targets, **asked)
    little = solve_dual(points, targets, **asked, megabytes=0.05)
    assert np.array_equal(much.weights, little.weights)
    assert np.array_equal(much.steps, little.steps)


def test_solving_again_gives_the_same_bits():
    points, targets = some_problem(400)
    first, second = (solve_dual(points, targets, C=5.0, epsilon=0.1, gamma=0.3) for _ in range(2))
    assert np.array_equal(first.weights, second.weights)


def test_a_start_nearby_saves_steps_and_ends_at_the_same_minimum():
    points, targets = some_problem(800, 4)
    near = solve_dual(points, targets, C=10.0, epsilon=0.1, gamma=0.3)
    for cost in (12.0, 5.0):
        cold = solve_dual(points, targets, C=cost, epsilon=0.1, gamma=0.3)
        warm = solve_dual(points, targets, C=cost, epsilon=0.1, gamma=0.3, start=near.weights)
        assert np.allclose(warm.objectives, cold.objectives, rtol=1e-4)
        assert np.abs(warm.weights).max() <= cost
        assert warm.steps.sum() < cold.steps.sum()


def test_progress_rises_to_one_and_can_stop_the_fit():
    points, targets = some_problem(1500, 6)
    told = []
    solve_dual(points, targets, C=10.0, epsilon=0.05, gamma=0.3, watch=told.append)
    assert len(told) > 4
    assert all(0.0 <= share <= 1.0 for share in told)
    assert told[-1] == 1.0

    class StopHereError(Exception):
        pass

    def stop(share):
        raise StopHereError

    with pytest.raises(StopHereError):
        SVRPolicy().fit(points, targets, progress=stop)


def test_giving_up_is_told(monkeypatch):
    monkeypatch.setattr(dual, "most_steps", lambda pairs: pairs)
    points, targets = some_problem(200)
    with pytest.warns(ConvergenceWarning, match=r"from the best fit, asked for 0\.001"):
        solution = solve_dual(points, targets, C=30.0, epsilon=0.01, gamma=0.3)
    assert (solution.steps == 200).all()


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 300])
@pytest.mark.parametrize("outputs", [1, 2, 5])
def test_compiled_decisions_are_the_plain_ones(count, outputs):
    rng = np.random.default_rng(count)
    scaling = Scaling(rng.normal(size=4), rng.uniform(0.1, 3, size=4))
    parts = (rng.normal(size=(count, 4)), rng.normal(size=(count, outputs)), 0.3)
    intercept = rng.normal(size=outputs)
    fast, plain = (Bumps(*parts, intercept, scaling, plain=flag) for flag in (False, True))
    states = scaling.offset + scaling.scale * rng.normal(size=(200, 4))
    assert np.allclose(fast.answer(states), plain.answer(states), rtol=0, atol=1e-12)


def test_states_far_away_get_the_intercept():
    machine = Bumps(
        np.zeros((3, 2)), np.ones((3, 1)), 5.0, np.array([0.25]), Scaling(np.zeros(2), np.ones(2))
    )
    for far in (1e3, 1e60, 1e200):
        assert machine.answer(np.full((1, 2), far))[0, 0] == pytest.approx(0.25)


def test_a_state_of_another_width_is_refused():
    machine = Bumps(
        np.zeros((3, 2)), np.ones((3, 1)), 1.0, np.zeros(1), Scaling(np.zeros(2), np.ones(2))
    )
    for states in (np.zeros((1, 3)), np.zeros(2)):
        with pytest.raises(InvalidInputError, match=r"expected \(rows, 2\)"):
            machine.answer(states)


@pytest.fixture(scope="module")
def fitted():
    """A policy of 1,200 pairs, the pairs, and others to judge it by."""
    points, targets = some_problem(2400, 8, noise=0.2)
    policy = SVRPolicy(C=10.0, epsilon=0.1, gamma=0.05).fit(points[:1200], targets[:1200])
    return policy, points, targets


@pytest.mark.parametrize("bases", [None, 100])
def test_the_answer_to_one_state_is_its_answer_in_any_batch(fitted, bases):
    policy, points, _ = fitted
    if bases:
        policy = policy.compact(points[:1200], bases)
    whole = policy.decide(points)
    for number in range(0, 2400, 37):
        assert np.array_equal(policy.decide(points[number : number + 1])[0], whole[number])
    for rows in (slice(3, 9), slice(1, 2000, 11), slice(None, None, -1)):
        assert np.array_equal(policy.decide(points[rows]), whole[rows])


def test_threads_get_the_answers_of_one(fitted):
    policy, points, _ = fitted
    wanted = policy.decide(points)
    found = [np.empty(0)] * 4

    def run(at):
        found[at] = np.vstack([policy.decide(points[row : row + 1]) for row in range(2400)])

    threads = [threading.Thread(target=run, args=(at,)) for at in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(answers, wanted) for answers in found)


def test_the_compact_form_errs_at_most_3_percent_more_on_held_out_pairs(fitted):
    policy, points, targets = fitted
    compact = policy.compact(points[:1200])
    assert len(compact.support_) <= 256 < len(policy.support_)
    errors = [
        np.sqrt(((one.decide(points[1200:]) - targets[1200:]) ** 2).mean())
        for one in (policy, compact)
    ]
    assert errors[1] <= 1.03 * errors[0]


def test_fitting_with_bases_is_fitting_and_then_compacting(fitted):
    policy, points, targets = fitted
    asked = {**policy.get_params(), "bases": 64}
    direct = SVRPolicy(**asked).fit(points[:1200], targets[:1200])
    later = policy.compact(points[:1200], 64)
    assert direct.get_params() == later.get_params() == asked
    assert np.array_equal(direct.decide(points), later.decide(points))
    assert len(direct.explain(points[:5]).pairs) == 5


def test_bases_are_never_chosen_twice_and_stop_when_all_is_described():
    points = np.repeat(np.arange(5.0), 20)[:, None]
    assert sorted(choose_bases(points, 2.0, 50)) == [0, 20, 40, 60, 80]


@pytest.mark.parametrize("bases", [0, -3, 2.5, "few"])
def test_bases_that_mean_nothing_are_named(bases):
    points, targets = some_problem(20)
    with pytest.raises(InvalidInputError, match="bases is"):
        SVRPolicy(bases=bases).fit(points, targets)


def test_a_compact_policy_is_at_most_10_kb_and_comes_back_exactly(asteroids, tmp_path):
    scene = asteroids()
    states, targets = some_problem(900, scene.perception("paper").state.size)
    pairs = Pairs(states, 0.1 * targets, np.repeat([0, 1, 2], 300), np.arange(900))
    policy = fit_policy(pairs, scene, "paper", "svr", {"bases": 256, "gamma": 0.1})
    path = save_policy(policy, tmp_path / "compact.safetensors")
    assert len(policy.learner.support_) == 256
    assert sum(array.nbytes for array in load_file(path).values()) <= 10_000
    again = load_policy(path)
    assert np.array_equal(again.act_states(states), policy.act_states(states))
    assert save_policy(again, tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def test_numba_is_loaded_at_first_use_only():
    code = "import sys, evastudio.learning.fitting; print('numba' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
