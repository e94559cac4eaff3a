"""Cleaning a session: what is marked, told by take, and why."""

import json

import numpy as np
import pytest

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import clean_pairs, explain_cleaning


def a_session(scene):
    """Two takes of 200 pairs on one smooth map, the second with a mistake of six decisions."""
    rng = np.random.default_rng(0)
    states = np.tile(np.linspace(0, 3, 200)[:, None], (2, scene.perception("canonical").state.size))
    states += rng.normal(scale=0.05, size=states.shape)
    actions = 0.05 * np.sin(states[:, :2]) + rng.normal(scale=0.001, size=(400, 2))
    actions[260:266] = -0.1
    return Pairs(states, actions, np.repeat([7, 3], 200), np.tile(np.arange(200), 2))


def test_a_mistake_is_marked_in_its_take_and_explained(asteroids):
    scene = asteroids()
    pairs = a_session(scene)
    cleaning = clean_pairs(pairs, scene)
    marked = np.flatnonzero(cleaning.conflicts)
    assert set(range(260, 266)) <= set(marked)
    report = json.loads(json.dumps(cleaning.report()))
    assert report["takes"] == {"3": (marked >= 200).sum(), "7": (marked < 200).sum()}
    assert report["threshold"] == "auto"
    why = explain_cleaning(cleaning, pairs)
    assert [conflict.pair for conflict in why] == marked.tolist()
    one = next(conflict for conflict in why if conflict.pair == 262)
    assert one.deviation == cleaning.deviations[262] > one.limit == cleaning.limits[262]
    apart = abs(pairs.moments[one.neighbors] - pairs.moments[262])
    assert apart.min() > cleaning.gap == round(0.6 / scene.dt_s)
    assert one.median[0] > 0.0 > pairs.actions[262, 0]


def test_other_pairs_than_those_looked_at_are_not_explained(asteroids):
    scene = asteroids()
    pairs = a_session(scene)
    cleaning = clean_pairs(pairs, scene)
    with pytest.raises(InvalidInputError, match="Clean again"):
        explain_cleaning(cleaning, pairs.keep(pairs.takes == 7))
