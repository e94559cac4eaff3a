"""Learners of numbers that decide among symbols: the symbol nearest to their answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError
from evastudio.learning.fitting import fit_policy
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.quantized import QuantizedKNNPolicy, QuantizedSVRPolicy
from evastudio.learning.svr import SVRPolicy
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.spaces import Symbols

WALKER = Path(__file__).parent.parent / "scenes" / "walker.py"
MOVES = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0))
RNG = np.random.default_rng(2)
STATES = RNG.normal(size=(300, 3))
CODES = np.select([STATES[:, 0] > 0.7, STATES[:, 0] < -0.7], [1, 2], default=3)


@pytest.mark.parametrize(
    "kinds", [(QuantizedSVRPolicy, SVRPolicy), (QuantizedKNNPolicy, KNNPolicy)]
)
def test_it_is_the_learner_of_numbers_and_then_the_nearest_move(kinds) -> None:
    quantized, plain = (kind() for kind in kinds)
    quantized.fit(STATES, CODES, classes=range(4), moves=MOVES)
    answers = plain.fit(STATES, np.array(MOVES)[CODES]).predict(STATES)
    nearest = np.hypot(*(answers[:, None] - np.array(MOVES)).T).T.argmin(axis=1)
    assert np.array_equal(quantized.predict(STATES), nearest)
    assert len(set(nearest)) > 1
    more = quantized.add_pairs(STATES[:5] + 0.1, CODES[:5])
    assert len(more.kept) == 305
    with pytest.raises(InvalidInputError, match="was not among those fitted"):
        quantized.add_pairs(STATES[:1], [7])


def test_between_left_and_right_lies_standing_still() -> None:
    """What votes never do: two of the shown moves average to a third, here to that of code 0."""
    states = np.zeros((40, 1))
    codes = np.repeat([1, 2], 20)
    policy = QuantizedKNNPolicy(k=40).fit(states, codes, classes=range(4), moves=MOVES)
    assert policy.predict([[0.0]]) == [0]


def test_a_compact_form_is_quantised_too() -> None:
    policy = QuantizedSVRPolicy(bases=20).fit(STATES, CODES, classes=range(4), moves=MOVES)
    whole = QuantizedSVRPolicy().fit(STATES, CODES, classes=range(4), moves=MOVES)
    assert (policy.predict(STATES) == whole.predict(STATES)).mean() > 0.9


@pytest.mark.parametrize("learner", ["quantized-svr", "quantized-knn"])
def test_a_policy_by_that_name_plays_a_scene_of_symbols(learner) -> None:
    walker = load_scene_file(WALKER)()
    worlds = walker.worlds(range(200))
    states = walker.perception().perceive(worlds).states
    pairs = Pairs(states, walker.intention(worlds), np.arange(200) // 10, np.arange(200) % 10)
    policy = fit_policy(pairs, walker, learner=learner)
    result = roll_out(walker, PolicyPilot(policy), range(1000, 1050), max_steps=500)
    assert (result.outcomes == walker.outcomes.index("arrived")).any()
    assert (policy.act_states(states) == pairs.actions).mean() > 0.7


def test_the_crowd_says_what_its_symbols_are_as_numbers() -> None:
    crowd = load_scene_file(shipped() / "scenes" / "crowd.py")(people=2, side=5)
    symbols = crowd.chosen(crowd.perception("paths"))
    frame = np.zeros((1, 2, 0))
    for code, move in enumerate(symbols.moves):
        given = crowd.perception("paths").to_world(frame, np.full((1, 2, 1), float(code)))
        assert given[0, 0, :2].tolist() == list(move)


def test_moves_that_do_not_fit_the_symbols_are_refused() -> None:
    for moves in (((0.0,),), ((0.0,), (1.0, 2.0))):
        with pytest.raises(InvalidInputError, match="give one for each"):
            Symbols(("stand", "go"), moves)
