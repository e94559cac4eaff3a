"""Eq. 2 against all pairs of pairs written out."""

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning import pairwise
from evastudio.learning.pairwise import pairwise_conflicts


@pytest.mark.parametrize("outputs", [1, 3])
def test_it_lists_what_equation_2_says(outputs, monkeypatch):
    monkeypatch.setattr(pairwise, "BLOCK", 64)
    rng = np.random.default_rng(outputs)
    states, actions = rng.normal(size=(300, 2)) * [1.0, 40.0], rng.normal(size=(300, outputs))
    scaled = (states - states.mean(axis=0)) / states.std(axis=0)
    shares = actions / np.ptp(actions, axis=0)
    near = np.linalg.norm(scaled[:, None] - scaled[None], axis=2) < 0.4
    apart = np.linalg.norm(shares[:, None] - shares[None], axis=2) > 0.3
    wanted = list(zip(*np.nonzero(np.triu(near & apart, 1)), strict=True))
    found = [
        pair
        for first, second in pairwise_conflicts(states, actions, 0.4, 0.3)
        for pair in zip(first, second, strict=True)
    ]
    assert found == wanted


def test_they_come_some_at_a_time():
    states = np.zeros((4000, 1))
    actions = np.arange(4000) % 2
    first, second = next(pairwise_conflicts(states, actions, 0.1, 0.5))
    assert len(first) == len(second) < 1024 * 4000
    assert (first < second).all()


def test_bad_input_is_named():
    with pytest.raises(InvalidInputError, match="NaN"):
        pairwise_conflicts([[np.nan]], [0.0], 0.1, 0.1)
    with pytest.raises(InvalidInputError, match="every state needs one action"):
        pairwise_conflicts([[0.0]], [0.0, 1.0], 0.1, 0.1)
    with pytest.raises(InvalidInputError, match="near is -1"):
        pairwise_conflicts([[0.0]], [0.0], -1, 0.1)
