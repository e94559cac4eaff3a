"""Each diagnosis on data made to have what it looks for, and on data made without."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from evastudio.demonstrations.pairs import join_pairs, see_take
from evastudio.learning.delay import estimate_delay, in_order
from evastudio.learning.diagnostics import diagnose
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds
from evastudio.world.snapshot import stack
from evastudio.world.spaces import Box, Field

DT = 1 / 15
TAKES, LONG = 8, 400


def wander(rng, memory=0.9, width=1):
    """Slow noise of spread 1 for all takes, shape (pairs, width)."""
    values = rng.normal(size=(TAKES * LONG, width))
    for row in range(1, len(values)):
        values[row] = memory * values[row - 1] + np.sqrt(1 - memory**2) * values[row]
    return values


def made(states, actions):
    return in_order(states, actions, np.repeat(np.arange(TAKES), LONG))


def box(width):
    return Box(tuple(Field(f"part_{at}", "m", -np.inf, np.inf) for at in range(width)))


def found(pairs):
    findings = diagnose(pairs, box(pairs.states.shape[1]), DT)
    assert {finding.name for finding in findings} == {"copies", "hidden", "ambiguous", "thin"}
    json.dumps([asdict(finding) for finding in findings])
    assert all(finding.sentence for finding in findings)
    return {finding.name: finding for finding in findings if finding.found}


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def test_nothing_is_found_in_plain_answers_to_what_is_seen(rng):
    states = wander(rng, width=3)
    actions = (
        np.tanh(states[:, :1]) + 0.3 * states[:, 1:2] + 0.2 * rng.normal(size=(len(states), 1))
    )
    assert found(made(states, actions)) == {}


def test_a_state_that_repeats_the_last_action_is_named(rng):
    actions = wander(rng)
    states = np.hstack([wander(rng, width=2), np.roll(actions, 1, axis=0)])
    states[:, 2:] += 0.05 * rng.normal(size=(len(states), 1))
    told = found(made(states, actions))["copies"]
    assert told.details["components"] == ["part_2"]
    assert "“part 2”" in told.sentence


def test_a_state_that_is_the_action_is_named(rng):
    actions = wander(rng)
    states = np.hstack([wander(rng, width=2), 3.0 * actions + 1.0])
    assert found(made(states, actions))["copies"].details["components"] == ["part_2"]


def test_decisions_made_from_something_else_are_hidden(rng):
    told = found(made(wander(rng, width=3), wander(rng)))
    assert set(told) == {"hidden"}
    assert "more visibly" in told["hidden"].sentence


def test_mere_noise_is_no_hidden_decision(rng):
    assert "hidden" not in found(made(wander(rng, width=3), rng.normal(size=(TAKES * LONG, 1))))


def test_like_states_answered_differently_for_a_while_each_are_ambiguous(rng):
    states = wander(rng, width=3)
    mood = np.sign(wander(rng, memory=0.99))
    told = found(made(states, states[:, :1] + 1.5 * mood))
    assert set(told) == {"ambiguous"}
    assert "missing" in told["ambiguous"].sentence


def test_short_mistakes_and_an_unsteady_hand_are_not_ambiguous(rng):
    states = wander(rng, width=3)
    actions = states[:, :1] + 0.5 * wander(rng, memory=0.6)
    for start in rng.choice(len(actions) - 4, 20, replace=False):
        actions[start : start + 4] *= -3.0
    assert "ambiguous" not in found(made(states, actions))


def test_a_place_that_only_one_take_went_to_is_named(rng):
    states = wander(rng, width=2)
    states[1000:1150, 1] += 12.0
    told = found(made(states, states[:, :1] + 0.1 * rng.normal(size=(len(states), 1))))["thin"]
    assert told.details["component"] == "part_1"
    assert told.details["low"] > 4.0
    assert told.details["high"] == states[:, 1].max()
    assert "Show more of that" in told.sentence


def test_one_take_is_looked_at_for_copies_only(rng):
    pairs = made(wander(rng, width=2), wander(rng))
    one = pairs.keep(pairs.takes == 0)
    assert [finding.name for finding in diagnose(one, box(2), DT)] == ["copies"]


def test_flat_states_and_actions_are_no_trouble():
    flat = np.ones((TAKES * LONG, 1))
    assert found(made(flat, flat)) == {}


@pytest.mark.parametrize("style", ["careful", "human"])
def test_nothing_is_found_in_scripted_flights(asteroids, style):
    scene = asteroids(density=4.0)
    view = scene.perception()
    seeds = world_seeds(7, 8)
    moments, done = [[] for _ in seeds], [[] for _ in seeds]

    def watch(alive, snapshot, actions):
        for row, world in enumerate(alive):
            moments[world].append(snapshot.take([row]))
            done[world].append(actions[row])

    roll_out(scene, find_pilot(f"scripted:{style}"), seeds, max_steps=300, watcher=watch)
    seen = [
        see_take(view, stack(moments[take]), np.array(done[take]), take)
        for take in range(len(seeds))
    ]
    late = estimate_delay(lambda steps: join_pairs([take.pairs(steps) for take in seen]), DT)
    pairs = join_pairs([take.pairs(late.steps) for take in seen])
    findings = diagnose(pairs, view.state, scene.dt_s)
    assert [finding.name for finding in findings if finding.found] == []
