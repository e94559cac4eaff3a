"""Familiarity: moments like those shown are evenly spread over 0 to 1, strange ones are at 0."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.learning.familiarity import Familiarity
from evastudio.learning.neighbors import NeighborIndex


def test_moments_of_another_take_of_the_same_kind_are_evenly_spread() -> None:
    rng = np.random.default_rng(4)
    states, takes = rng.normal(size=(3000, 3)), np.repeat(np.arange(10), 300)
    familiarity = Familiarity(states, takes)
    fresh = rng.normal(size=(2000, 3))
    distances, _ = NeighborIndex(states).nearest(fresh, 1)
    shares = familiarity.of(distances[:, 0])
    # Twice as many demonstrations lie about as when it was told how far apart takes are, so they
    # are a little nearer: the median is above a half, and no share of them is far off.
    assert 0.45 < np.median(shares) < 0.7
    assert (shares < 0.05).mean() < 0.08
    assert ((shares > 0.0) & (shares <= 1.0)).all()


def test_what_was_never_shown_is_unfamiliar_and_what_was_shown_is_familiar() -> None:
    rng = np.random.default_rng(5)
    states, takes = rng.normal(size=(2000, 2)), np.repeat(np.arange(4), 500)
    familiarity = Familiarity(states, takes)
    assert familiarity.of(np.array(0.0)) == 1.0
    assert familiarity.of(np.array(10.0)) == pytest.approx(1 / 2001)
    assert (np.diff(familiarity.of(np.linspace(0.0, 1.0, 50))) <= 0.0).all()


def test_one_take_is_parted_in_its_middle() -> None:
    states = np.linspace(0.0, 1.0, 100)[:, None]
    familiarity = Familiarity(states, np.zeros(100, dtype=np.int64))
    # The nearest moment of the other half is up to half the way off.
    assert familiarity.of(np.array(0.25)) == pytest.approx(0.5, abs=0.05)
