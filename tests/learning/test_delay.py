import numpy as np
import pytest

from evastudio.demonstrations.pairs import Pairs, answered_pairs, join_pairs, see_take
from evastudio.errors import InvalidInputError
from evastudio.learning.delay import estimate_delay, estimate_delay_of_arrays, in_order
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import roll_out
from evastudio.world.snapshot import stack

DT = 1 / 15


def wander(rng, pairs, width, memory=0.9):
    """Noise that changes slowly, shape (pairs, width)."""
    values = rng.normal(size=(pairs, width))
    for row in range(1, pairs):
        values[row] += memory * values[row - 1]
    return values


def answered_late(delay_steps, takes=8, pairs=300, noise=0.5, seed=0):
    """Takes whose actions answer the state of `delay_steps` before, with noise."""
    rng = np.random.default_rng(seed)
    parts = []
    for _ in range(takes):
        states = wander(rng, pairs + delay_steps, 4)
        answers = states @ [[1.0, 0.0], [0.3, 1.0], [0.0, 0.5], [0.0, 0.0]]
        done = answers[:pairs] + noise * wander(rng, pairs, 2)
        parts.append((states[delay_steps:], done))
    states, actions = (np.concatenate(part) for part in zip(*parts, strict=True))
    return states, actions, np.repeat(np.arange(takes), pairs)


@pytest.mark.parametrize("steps", [1, 3, 6, 9])
def test_a_known_delay_is_found_and_taken_out(steps):
    found = estimate_delay_of_arrays(*answered_late(steps), DT)
    assert found.delay_s == pytest.approx(steps * DT, abs=0.03)
    assert found.low_s <= found.delay_s <= found.high_s
    assert found.steps == steps
    assert found.helps
    assert found.gain > 0.1
    assert "late; the policy does not" in found.sentence()


def test_no_delay_is_found_to_be_none():
    found = estimate_delay_of_arrays(*answered_late(0), DT)
    assert (found.delay_s, found.steps, found.high_s, found.gain) == (0.0, 0, 0.0, 0.0)
    assert "No delay" in found.sentence()


@pytest.mark.parametrize("seed", range(5))
def test_actions_that_answer_nothing_have_no_delay(seed):
    rng = np.random.default_rng(seed)
    takes = np.repeat(np.arange(4), 150)
    assert not estimate_delay_of_arrays(wander(rng, 600, 4), wander(rng, 600, 2), takes, DT).helps


def test_one_take_gives_no_estimate_and_says_so():
    states, actions, takes = answered_late(3, takes=1)
    found = estimate_delay_of_arrays(states, actions, takes, DT)
    assert (found.delay_s, found.steps, found.takes) == (0.0, 0, 1)
    assert "two takes" in found.sentence()


def test_takes_shorter_than_the_delays_tried_give_none():
    states, actions, takes = answered_late(3, takes=40, pairs=8)
    assert estimate_delay_of_arrays(states, actions, takes, DT).takes == 0


def test_decisions_far_apart_give_none_and_say_so():
    found = estimate_delay_of_arrays(*answered_late(1), 0.7)
    assert (found.steps, found.lags_s) == (0, ())
    assert "too far apart" in found.sentence()


def test_moments_that_do_not_count_leave_gaps_and_no_harm():
    pairs = in_order(*answered_late(3))
    meant = np.random.default_rng(1).random(len(pairs)) < 0.97
    found = estimate_delay(lambda steps: answered_in(pairs, meant, steps), DT)
    assert found.steps == 3


def answered_in(pairs, meant, steps):
    """Pairs with a delay taken out, of which both moments are `meant` (pairs,)."""
    late = answered_pairs(pairs, steps)
    rows = pairs.takes * 1000 + pairs.steps
    now = np.searchsorted(rows, late.takes * 1000 + late.steps)
    return late.keep(meant[now] & meant[now - steps])


def test_it_repeats_and_does_not_change_with_the_unit_of_actions():
    states, actions, takes = answered_late(3)
    one = estimate_delay_of_arrays(states, actions, takes, DT)
    assert one == estimate_delay_of_arrays(states, actions, takes, DT)
    other = estimate_delay_of_arrays(states * 1e3, actions * 1e-3, takes, DT)
    assert other.delay_s == pytest.approx(one.delay_s, abs=1e-6)


def test_a_step_must_be_a_time():
    with pytest.raises(InvalidInputError, match="decision step"):
        estimate_delay_of_arrays(*answered_late(3), 0.0)


def test_a_constant_action_has_no_delay():
    states, actions, takes = answered_late(3)
    assert not estimate_delay_of_arrays(states, np.ones_like(actions), takes, DT).helps


def test_finished_pairs_are_shifted_within_their_takes_and_over_no_gap():
    steps = np.array([0, 1, 2, 4, 5, 0, 1, 2])
    takes = np.array([7, 7, 7, 7, 7, 9, 9, 9])
    pairs = Pairs(steps[:, None] * 1.0, steps[:, None] * 10.0, takes, steps)
    late = answered_pairs(pairs, 1)
    assert late.takes.tolist() == [7, 7, 7, 9, 9]
    assert late.steps.tolist() == [1, 2, 5, 1, 2]
    assert np.array_equal(late.states[:, 0], late.steps - 1.0)
    assert np.array_equal(late.actions[:, 0], late.steps * 10.0)
    assert len(answered_pairs(pairs, 50)) == 0


def test_rows_of_a_take_count_from_its_beginning():
    pairs = in_order(np.zeros((5, 2)), np.arange(5.0), np.array([3, 3, 8, 8, 8]))
    assert pairs.steps.tolist() == [0, 1, 0, 1, 2]
    assert pairs.actions.shape == (5, 1)


def flown(scene, pilot, seed, take=0, steps=400):
    """One take of `pilot` as `canonical` shows it, and its moments."""
    moments, done = [], []

    def watch(_, snapshot, actions):
        moments.append(snapshot)
        done.append(actions[0])

    roll_out(scene, pilot, [seed], max_steps=steps, watcher=watch)
    whole = stack(moments)
    return see_take(scene.perception("canonical"), whole, np.array(done), take), whole


def test_an_action_is_turned_into_the_frame_of_the_moment_it_answers(asteroids):
    """The canonical view rolls: the same action is another one in each moment's frame."""
    scene = asteroids()
    seen, moments = flown(scene, find_pilot("scripted:careful"), 11, take=5, steps=60)
    late = seen.pairs(3)
    assert late.steps.tolist() == list(range(3, 60))
    assert set(late.takes) == {5}
    before = seen.perception.perceive(moments.take(late.steps - 3))
    assert np.array_equal(late.states, before.states)
    assert np.array_equal(
        seen.perception.to_world(before.frame, late.actions).round(9),
        seen.actions[late.steps].round(9),
    )
    assert len(seen.pairs(100)) == 0


@pytest.mark.parametrize("delay_steps", [0, 4])
def test_a_scripted_demonstrators_delay_is_found_through_a_perception(asteroids, delay_steps):
    scene = asteroids(density=4.0)
    late = find_pilot("scripted:careful", delay_steps=delay_steps)
    seen = [flown(scene, late, seed, seed)[0] for seed in range(1, 6)]
    found = estimate_delay(lambda d: join_pairs([take.pairs(d) for take in seen]), scene.dt_s)
    assert found.steps == delay_steps
    assert found.delay_s == pytest.approx(delay_steps * scene.dt_s, abs=0.07)


def test_actions_that_never_change_show_no_delay():
    rng = np.random.default_rng(3)
    takes = np.repeat(np.arange(6), 100)
    found = estimate_delay_of_arrays(wander(rng, 600, 2), np.full((600, 2), 0.3), takes, DT)
    assert "No delay" in found.sentence()


def test_states_that_are_no_numbers_are_refused():
    states, actions, takes = answered_late(2, takes=3, pairs=50)
    states[7, 1] = np.nan
    with pytest.raises(InvalidInputError, match="states"):
        estimate_delay_of_arrays(states, actions, takes, DT)
    with pytest.raises(InvalidInputError, match="differ in length"):
        estimate_delay_of_arrays(states[:90], actions, takes, DT)


def test_a_delay_of_less_than_a_tenth_of_a_second_is_not_told_as_none():
    found = estimate_delay_of_arrays(*answered_late(1), 0.02, longest_s=0.1)
    assert "about 0.02 s late" in found.sentence()
