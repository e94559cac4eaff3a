"""Feet stay where they stand, whatever is decided next, and nobody jumps on the way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.motion.figures import figures
from evastudio.motion.footing import (
    TOUCHDOWNS,
    Passage,
    at_home,
    complex_of,
    settling,
)

DT_S = 0.5


def passage(rng: np.random.Generator, count: int = 40) -> Passage:
    """Anybody between any two decisions."""
    start, way = rng.normal(0, 5, (count, 2)), rng.uniform(-np.pi, np.pi, count)
    speed = rng.uniform(0, 4, count)
    phase = rng.uniform(0, 50, count)
    return Passage(
        figures(),
        DT_S,
        complex_of(start),
        complex_of(start + rng.normal(0, 0.7, (count, 2))),
        speed * np.exp(1j * way),
        (way, way + rng.normal(0, 0.5, count)),
        (phase, phase + rng.choice([0.0, 0.3, 0.5, 0.9], count)),
        rng.uniform(0.9, 1.1, count),
        rng.uniform(-1, 1, count),
    )


def feet_at(way: Passage) -> np.ndarray:
    return at_home(way.position(0.0), way.headings[0])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_a_foot_comes_down_where_it_was_led_to(seed: int) -> None:
    way = passage(np.random.default_rng(seed))
    before = feet_at(way)
    after = way.landed(before)
    now = way.phases[0][:, None] - TOUCHDOWNS
    left = np.floor(now) + 1.0 - now
    cycles = (way.phases[1] - way.phases[0])[:, None]
    lands = left / np.maximum(cycles, 1e-9)
    for share in np.linspace(0.02, 1.0, 12):
        footing = way.footing(float(share), before, after)
        assert np.isfinite(footing.aims).all()
        np.testing.assert_array_equal(footing.stood[lands > share], before[lands > share])
        np.testing.assert_array_equal(footing.stood[lands <= share], after[lands <= share])
        near = (lands > share) & (lands - share < 0.02) & (lands < 1.0)
        assert np.abs(footing.aims[near] - after[near]).max(initial=0.0) < 0.12


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_a_body_goes_on_as_fast_as_it_came(seed: int) -> None:
    rng = np.random.default_rng(seed)
    way = passage(rng)
    at, velocity = way.place(0.0)
    np.testing.assert_allclose(at, way.start)
    np.testing.assert_allclose(velocity, way.entering)
    at, velocity = way.place(1.0)
    np.testing.assert_allclose(at, way.end)
    np.testing.assert_allclose(velocity, (way.end - way.start) / DT_S)
    here, there = way.place(0.4)[0], way.place(0.4 + 1e-6)[0]
    np.testing.assert_allclose((there - here) / 1e-6 / DT_S, way.place(0.4)[1], atol=1e-3)
    assert np.abs(way.turn_rate(0.0)).max() == np.abs(way.turn_rate(1.0)).max() == 0.0


def test_who_stops_brings_the_feet_together_and_then_rests() -> None:
    position, heading = np.zeros((1, 2)), np.zeros(1)
    feet, phase = at_home(position, heading), np.array([7.3])
    feet[0, 0, 0] = 0.3
    steps = 0
    while (cycles := settling(feet, position, heading, phase)).any():
        steps += 1
        there = complex_of(position)
        way = Passage(
            figures(),
            DT_S,
            there,
            there,
            there * 0,
            (heading, heading),
            (phase, phase + cycles),
            np.ones(1),
            np.zeros(1),
        )
        feet, phase = way.landed(feet), phase + cycles
        assert steps < 4
    np.testing.assert_allclose(feet, at_home(position, heading), atol=1e-9)


@pytest.mark.parametrize("speed", [0.3, 0.8, 1.4, 2.0, 4.0])
def test_in_even_walking_aims_stand_still(speed: float) -> None:
    cadence = float(figures().cadence(speed))
    way = Passage(
        figures(),
        DT_S,
        np.zeros(1, dtype=complex),
        np.full(1, speed * DT_S + 0j),
        np.full(1, speed + 0j),
        (np.zeros(1), np.zeros(1)),
        (np.full(1, 3.2), np.full(1, 3.2 + cadence * DT_S)),
        np.ones(1),
        np.zeros(1),
    )
    feet = feet_at(way)
    shares = np.linspace(0.0, min(0.29 / cadence / DT_S, 0.99), 6)
    aims = [way.footing(float(share), feet, feet).aims[0, 1] for share in shares]
    assert np.ptp(np.array(aims), axis=0).max() < 0.01
