"""Figures: limbs that hold together, in any crowd."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.motion.body import FOREARM, SHANK, THIGH, UPPER_ARM
from evastudio.motion.figures import JOINTS, Figures
from evastudio.motion.moment import Activity, Moment

FIGURES = Figures()


def crowd(seed: int, count: int = 40) -> Moment:
    rng = np.random.default_rng(seed)
    return Moment(
        positions=rng.uniform(-50, 50, (count, 2)),
        headings=rng.uniform(-9, 9, count),
        speeds=rng.uniform(0, 6, count),
        phases=rng.uniform(-3, 30, count),
        turn_rates=rng.normal(0, 1, count),
        activities=rng.integers(0, len(Activity), count),
        since_s=rng.uniform(0, 3, count),
        times_s=rng.uniform(0, 900, count),
        sizes=rng.uniform(0.8, 1.15, count),
        manners=rng.uniform(-1, 1, count),
        looks=rng.integers(0, 9999, count),
    )


def one(moment: Moment, row: int) -> Moment:
    given = {name: array for name, array in vars(moment).items() if array is not None}
    return Moment(**{name: array[row : row + 1] for name, array in given.items()})


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_limbs_keep_their_length_whatever_is_done(seed: int) -> None:
    moment = crowd(seed)
    joints = FIGURES.joints(moment)
    where = dict(zip(JOINTS, joints.positions, strict=True))
    for upper, lower, length in (
        ("thigh", "shank", THIGH),
        ("shank", "foot", SHANK),
        ("upper_arm", "forearm", UPPER_ARM),
        ("forearm", "hand", FOREARM),
    ):
        for side in ("left", "right"):
            apart = np.linalg.norm(where[f"{side}_{lower}"] - where[f"{side}_{upper}"], axis=1)
            np.testing.assert_allclose(apart, length * moment.sizes, rtol=2e-4, atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(joints.wxyzs, axis=2), 1, atol=1e-4)


def test_a_crowd_moves_as_its_characters_do_one_by_one() -> None:
    moment = crowd(3)
    together = FIGURES.joints(moment)
    for row in range(len(moment.positions)):
        alone = FIGURES.joints(one(moment, row))
        np.testing.assert_allclose(alone.positions[:, 0], together.positions[:, row], atol=1e-5)


def test_every_body_has_as_many_of_each_array_and_a_mesh() -> None:
    moment = crowd(4)
    *limbs, shadows = FIGURES.bodies(moment)
    assert len(shadows.positions) == len(moment.positions)
    for body in limbs:
        assert body.mesh in FIGURES.meshes()
        count = len(body.positions)
        assert body.wxyzs.shape == (count, 4)
        assert body.scales.shape == (count, 3)
        assert body.colors is not None
        assert body.colors.shape == (count, 3)
        assert np.isfinite(body.positions).all()
    hairs = [len(body.positions) for body in FIGURES.bodies(moment) if "hair" in body.name]
    assert sum(hairs) == len(moment.positions)
    assert FIGURES.bodies(crowd(0, 0))[0].positions.shape == (0, 3)


def frames(activity: Activity, seconds: float, rate: float = 120.0) -> Moment:
    since = np.arange(int(seconds * rate)) / rate
    count = len(since)
    return Moment(
        np.zeros((count, 2)),
        np.zeros(count),
        activities=np.full(count, activity),
        since_s=since,
        times_s=since,
    )


@pytest.mark.parametrize("activity", [Activity.STAGGER, Activity.FALLEN, Activity.GETTING_UP])
def test_nothing_jumps_while_a_movement_runs(activity: Activity) -> None:
    length_s = FIGURES.length_s(activity)
    places = FIGURES.joints(frames(activity, length_s + 0.5)).positions
    speed = np.linalg.norm(np.diff(places, axis=1), axis=2).max() * 120.0
    assert speed < 9.0  # m/s: hands fly that fast, nothing teleports


def test_one_movement_begins_where_the_one_before_ended() -> None:
    still = replace(frames(Activity.STAND, 0.01), times_s=np.zeros(1))
    places = {}
    for activity in (Activity.STAGGER, Activity.FALLEN, Activity.GETTING_UP):
        for when in (0.0, FIGURES.length_s(activity)):
            moment = replace(still, activities=np.array([activity]), since_s=np.array([when]))
            places[activity, when > 0] = FIGURES.joints(moment).positions
    standing = FIGURES.joints(still).positions
    for key in ((Activity.STAGGER, False), (Activity.FALLEN, False), (Activity.STAGGER, True)):
        np.testing.assert_allclose(places[key], standing, atol=1e-5)
    np.testing.assert_allclose(places[Activity.GETTING_UP, True], standing, atol=1e-5)
    lying = places[Activity.FALLEN, True]
    np.testing.assert_allclose(places[Activity.GETTING_UP, False], lying, atol=1e-5)
    assert lying[JOINTS.index("head"), 0, 2] < 0.3


def test_speeding_up_never_makes_a_limb_jump() -> None:
    speeds = np.linspace(0, 6, 1200)
    count = len(speeds)
    moment = Moment(np.zeros((count, 2)), np.zeros(count), speeds, np.full(count, 0.3))
    places = FIGURES.joints(moment).positions
    assert np.linalg.norm(np.diff(places, axis=1), axis=2).max() < 0.02


def test_manners_are_told_apart() -> None:
    moment = Moment(
        np.zeros((3, 2)), np.zeros(3), np.full(3, 1.2), np.zeros(3), manners=np.array([-1.0, 0, 1])
    )
    cadence = FIGURES.cadence(moment.speeds, manners=moment.manners)
    assert cadence[0] > cadence[1] > cadence[2]  # shy steps are small
    where = dict(zip(JOINTS, FIGURES.joints(moment).positions, strict=True))
    apart = np.abs(where["left_hand"][:, 0] - where["right_hand"][:, 0])
    assert apart[0] < 0.6 * apart[1] < 0.6 * apart[2]


def test_a_moment_refuses_arrays_of_another_length() -> None:
    with pytest.raises(InvalidInputError, match=r"speeds have shape \(3,\); expected \(2,\)"):
        Moment(np.zeros((2, 2)), np.zeros(2), np.zeros(3))
    with pytest.raises(InvalidInputError, match="positions have shape"):
        Moment(np.zeros(4), np.zeros(4))


@pytest.mark.parametrize("name", ["positions", "headings", "speeds", "phases", "sizes", "times_s"])
def test_a_moment_refuses_what_is_not_finite(name: str) -> None:
    arrays = dict(vars(crowd(5)))
    arrays[name] = arrays[name] * np.nan
    with pytest.raises(InvalidInputError, match=name):
        Moment(**arrays)
    with pytest.raises(InvalidInputError, match="sizes"):
        Moment(np.zeros((2, 2)), np.zeros(2), sizes=np.zeros(2))
