"""Rotations obey the laws of rotations, in any shape of batch."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from evastudio.motion.rotations import (
    about,
    between,
    from_axes,
    inverse,
    normalized,
    product,
    rotated,
    slerp,
)

SEEDS = st.integers(0, 2**32 - 1)


def drawn(seed: int, width: int) -> np.ndarray:
    return normalized(np.random.default_rng(seed).normal(size=(3, 5, width)))


@given(SEEDS)
def test_a_product_does_the_second_then_the_first(seed: int) -> None:
    a, b, v = drawn(seed, 4), drawn(seed + 1, 4), drawn(seed + 2, 3)
    np.testing.assert_allclose(rotated(product(a, b), v), rotated(a, rotated(b, v)), atol=1e-12)
    np.testing.assert_allclose(rotated(inverse(a), rotated(a, v)), v, atol=1e-12)


@given(SEEDS)
def test_axes_and_rotation_are_two_forms_of_one_thing(seed: int) -> None:
    turn = drawn(seed, 4)
    axes = [rotated(turn, np.broadcast_to(axis, (3, 5, 3))) for axis in np.eye(3)]
    back = from_axes(*axes)
    assert np.abs(np.abs((back * turn).sum(axis=-1)) - 1).max() < 1e-9


@given(SEEDS)
def test_slerp_runs_from_one_to_the_other_at_an_even_pace(seed: int) -> None:
    a, b = drawn(seed, 4), drawn(seed + 1, 4)
    np.testing.assert_allclose(slerp(a, b, 0.0), a, atol=1e-6)
    half = slerp(a, b, 0.5)
    to_a, to_b = np.abs((half * a).sum(axis=-1)), np.abs((half * b).sum(axis=-1))
    np.testing.assert_allclose(to_a, to_b, atol=1e-9)


@given(SEEDS)
def test_between_leads_one_direction_to_the_other(seed: int) -> None:
    a, b = drawn(seed, 3), drawn(seed + 1, 3)
    np.testing.assert_allclose(rotated(between(a, b), a), b, atol=1e-9)
    np.testing.assert_allclose(rotated(between(a, -a), a), -a, atol=1e-9)


def test_positive_angles_turn_right_handed() -> None:
    quarter = np.array(np.pi / 2)
    forward = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(rotated(about(2, quarter), forward), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(rotated(about(1, quarter), forward), [0, 0, -1], atol=1e-12)
