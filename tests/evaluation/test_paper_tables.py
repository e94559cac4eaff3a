"""Quantities read well, and what a learner holds is counted once."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.evaluation.paper import Extent
from evastudio.evaluation.paper_costs import held_bytes
from evastudio.evaluation.paper_tables import quantity
from evastudio.learning.knn import KNNPolicy


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (13e-6, "s", "13 us"),
        (7.04e-3, "s", "7.04 ms"),
        (36.1, "s", "36.1 s"),
        (480.0, "s", "8 min"),
        (8280.0, "s", "2.3 h"),
        (604800.0, "s", "7 days"),
        (0.9999, "s", "1 s"),
        (8e9, "B", "8 GB"),
        (370e6, "B", "370 MB"),
        (10e3, "B", "10 KB"),
        (6000, "", "6,000"),
        (0.0, "%", "0 %"),
        (None, "s", ""),
    ],
)
def test_quantities_are_in_the_unit_that_the_paper_would_use(
    value: float | None, unit: str, said: str
) -> None:
    assert quantity(value, unit) == said


def test_every_array_counts_once() -> None:
    states = np.random.default_rng(0).normal(size=(100, 6))
    learner = KNNPolicy(k=3).fit(states, states[:, :2])
    before = held_bytes(learner)
    assert before >= states.nbytes + states[:, :2].nbytes
    learner.again = [learner.states_, learner]
    assert held_bytes(learner) == before


def test_what_is_timed_must_be_measured() -> None:
    with pytest.raises(InvalidInputError, match="none of"):
        Extent(densities=(1.0,))
