"""Clips between their moments, and legs between hip and ground."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from evastudio.motion.body import SHANK, THIGH
from evastudio.motion.clip import Clip
from evastudio.motion.legs import LONGEST, SHORTEST, legs
from evastudio.motion.rotations import about, rotated
from evastudio.motion.skeleton import Skeleton


def arm(turns: np.ndarray) -> Clip:
    """A shoulder that turns about y, and an elbow 1 m below it."""
    skeleton = Skeleton(("shoulder", "elbow"), (-1, 0), np.array([[0, 0, 2.0], [0, 0, -1.0]]))
    rotations = np.stack([about(1, turns), about(1, 0 * turns)], axis=1)
    return Clip("arm", skeleton, 10.0, np.tile(skeleton.offsets, (len(turns), 1, 1)), rotations)


def test_a_clip_is_read_between_its_moments_and_stops_at_its_ends() -> None:
    clip = arm(np.array([0.0, 1.0, 0.5]))
    _, turns = clip.sample(np.array([-1.0, 0.05, 0.1, 0.15, 9.0]))
    angles = 2 * np.arctan2(turns[:, 0, 2], turns[:, 0, 0])
    np.testing.assert_allclose(angles, [0.0, 0.5, 1.0, 0.75, 0.5], atol=1e-9)
    assert clip.duration_s == 0.2


def test_a_turn_of_the_other_sign_is_no_jump() -> None:
    good = arm(np.linspace(0, 1, 5))
    flipped = good.rotations * np.array([1, -1, 1, -1, 1.0])[:, None, None]
    same = Clip("arm", good.skeleton, 10.0, good.translations, flipped)
    np.testing.assert_allclose(same.rotations, good.rotations)


def test_joints_hang_on_their_parents() -> None:
    places, _ = arm(np.array([0.0, np.pi / 2])).world()
    np.testing.assert_allclose(places[:, 1], [[0, 0, 1], [-1, 0, 2]], atol=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_legs_end_where_their_feet_are_and_knees_bend_ahead(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sockets = rng.normal(size=(2, 6, 3))
    way = rng.normal(size=(2, 6, 3)) * (0.4, 0.2, 0.1) - (0, 0, 1.0)
    length = rng.uniform(SHORTEST, LONGEST, (2, 6, 1))
    ankles = sockets + way / np.linalg.norm(way, axis=-1, keepdims=True) * length
    hinges = np.broadcast_to([0.0, 1.0, 0.0], (2, 6, 3))
    knees, reached, thighs, shanks = legs(sockets, ankles, hinges)
    np.testing.assert_allclose(reached, ankles, atol=1e-9)
    down = np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(knees, sockets + THIGH * rotated(thighs, down), atol=1e-7)
    np.testing.assert_allclose(ankles, knees + SHANK * rotated(shanks, down), atol=1e-7)
    ahead = rotated(thighs, np.array([1.0, 0.0, 0.0]))
    bend = ((knees - (sockets + ankles) / 2) * ahead).sum(axis=-1)
    assert (bend > -1e-9).all()


def test_a_foot_out_of_reach_is_drawn_nearer() -> None:
    sockets, far = np.zeros((1, 3)), np.array([[0.0, 0.0, -3.0]])
    _, reached, _, _ = legs(sockets, far, np.array([[0.0, 1.0, 0.0]]))
    np.testing.assert_allclose(reached, [[0, 0, -LONGEST]], atol=1e-12)
