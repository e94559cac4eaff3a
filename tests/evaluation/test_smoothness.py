"""Smoothness against movements whose measures are known."""

import numpy as np
import pytest

from evastudio.evaluation.smoothness import log_dimensionless_jerk, spectral_arc_length


def minimum_jerk(moments: int) -> np.ndarray:
    """The speed of the smoothest reach of a second and a metre (Flash and Hogan, 1985)."""
    share = np.linspace(0.0, 1.0, moments)
    return 30.0 * (share**2 - 2.0 * share**3 + share**4)


def test_the_smoothest_reach_has_the_jerk_that_its_polynomial_gives():
    """The integral of its squared jerk is 720, its top speed 15 / 8: minus ln 204.8."""
    found = log_dimensionless_jerk(minimum_jerk(4001)[:, None], 1 / 4000)
    assert found == pytest.approx(-np.log(720 / (15 / 8) ** 2), abs=2e-3)


def test_the_smoothest_reach_has_the_published_arc_length():
    """-1.41, Balasubramanian and others, 2015."""
    assert spectral_arc_length(minimum_jerk(401), 1 / 400) == pytest.approx(-1.41, abs=0.005)


def test_neither_depends_on_the_size_or_the_duration_of_a_movement():
    speed = minimum_jerk(301)
    jerk, arc = log_dimensionless_jerk(speed[:, None], 0.005), spectral_arc_length(speed, 0.005)
    assert log_dimensionless_jerk(7.0 * speed[:, None], 0.005) == pytest.approx(jerk)
    assert log_dimensionless_jerk(speed[:, None], 0.02) == pytest.approx(jerk)
    assert spectral_arc_length(7.0 * speed, 0.005) == pytest.approx(arc)


def test_two_strokes_are_less_smooth_than_one():
    one, two = minimum_jerk(400), np.tile(minimum_jerk(200), 2)
    assert spectral_arc_length(two, 0.0025) < spectral_arc_length(one, 0.0025)
    assert log_dimensionless_jerk(two[:, None], 0.0025) < log_dimensionless_jerk(
        one[:, None], 0.0025
    )


def test_what_does_not_move_has_no_smoothness():
    assert np.isnan(log_dimensionless_jerk(np.zeros((9, 2)), 0.1))
    assert np.isnan(log_dimensionless_jerk(np.ones((3, 2)), 0.1))
    assert log_dimensionless_jerk(np.ones((9, 2)), 0.1) == np.inf
    steady = np.diff(np.arange(500.0)[:, None] * (10.0 / 15.0, 0.1), axis=0) * 15.0
    assert np.ptp(steady[:, 0]) > 0.0, "its last digits change"
    assert log_dimensionless_jerk(steady, 1 / 15) == np.inf
    assert np.isnan(spectral_arc_length(np.zeros(9), 0.1))
    assert np.isnan(spectral_arc_length(np.ones(3), 0.1))
