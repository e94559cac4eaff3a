"""Clips of other programs on the shipped body: what comes in walks as it did."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.motion.bvh import read_bvh
from evastudio.motion.clip import Clip
from evastudio.motion.figures import Figures
from evastudio.motion.glb import Glb
from evastudio.motion.keyposes import RATE_HZ
from evastudio.motion.moment import Activity, Moment
from evastudio.motion.movements import movement_of
from evastudio.motion.naming import named_parts
from evastudio.motion.retarget import retargeted
from evastudio.motion.skeleton import Skeleton
from evastudio.motion.sliding import sliding_cm
from evastudio.motion.steps import gait_of
from tests.motion.walker import FIGURES, bvh, glb, walking

SPEED = 1.2
LIMBS = ("thigh", "shank", "foot", "upper_arm", "forearm")


@pytest.mark.parametrize("moves", [True, False], ids=["moving on", "on the spot"])
@pytest.mark.parametrize("kind", ["bvh", "glb"])
def test_a_walk_keeps_its_steps_and_does_not_slide(kind: str, moves: bool) -> None:
    walk = walking(SPEED, moves=moves)
    clip = (
        read_bvh(bvh(walk).encode(), "walk") if kind == "bvh" else Glb(glb(walk), "w").clip("walk")
    )
    gait = gait_of(retargeted(clip), clip.rate_hz, clip.name)
    assert gait.speed == pytest.approx(SPEED, rel=0.08)
    assert gait.stride_m == pytest.approx(SPEED / float(FIGURES.cadence(SPEED)), rel=0.08)
    figures = Figures({Activity.WALK: gait})
    for speed in (0.5, SPEED, 1.7):
        assert sliding_cm(figures, speed).max() < 3.0
        assert sliding_cm(figures, speed, turn_rate=0.5).max() < 3.0


def test_both_readers_see_the_same_movement() -> None:
    walk = walking(SPEED)
    text, binary = read_bvh(bvh(walk).encode(), "walk"), Glb(glb(walk), "walk").clip("walk")
    first = dict(zip(text.skeleton.names, np.moveaxis(text.world()[0], 1, 0), strict=True))
    second = dict(zip(binary.skeleton.names, np.moveaxis(binary.world()[0], 1, 0), strict=True))
    for name, places in first.items():
        np.testing.assert_allclose(places[::2][: len(second[name])], second[name], atol=0.05)


def test_a_body_of_another_size_makes_the_same_movement() -> None:
    walk = walking(SPEED)
    tall = Clip(
        walk.name,
        replace(walk.skeleton, offsets=walk.skeleton.offsets * 7),
        walk.rate_hz,
        walk.translations * 7,
        walk.rotations,
    )
    plain, large = retargeted(walk), retargeted(tall)
    np.testing.assert_allclose(plain.ankles, large.ankles, atol=1e-9)
    np.testing.assert_allclose(plain.upper, large.upper, atol=1e-9)


def test_a_clip_that_stands_is_no_walk_but_may_be_a_stand() -> None:
    still = walking(SPEED, 0.8)
    frozen = Clip(
        "still",
        still.skeleton,
        still.rate_hz,
        np.repeat(still.translations[:1], 90, axis=0),
        np.repeat(still.rotations[:1], 90, axis=0),
    )
    poses = retargeted(frozen)
    with pytest.raises(InvalidInputError, match="No two steps were found in clip 'still'"):
        gait_of(poses, frozen.rate_hz, frozen.name)
    stand = movement_of(poses, frozen.rate_hz, frozen.name, repeats=True)
    assert len(stand) == round(89 / 60 * RATE_HZ) + 1
    figures = Figures({}, {Activity.STAND: stand})
    assert np.isfinite(
        figures.bodies(Moment(np.zeros((3, 2)), np.zeros(3), times_s=np.arange(3.0)))[0].positions
    ).all()


def test_a_movement_without_end_is_refused() -> None:
    walk = walking(SPEED, 25.0)
    with pytest.raises(InvalidInputError, match="lasts 25 s"):
        movement_of(retargeted(walk), walk.rate_hz, "long")


def test_walking_cannot_be_chosen_as_a_movement() -> None:
    poses = retargeted(walking(SPEED))
    with pytest.raises(InvalidInputError, match="TURN"):
        Figures({}, {Activity.TURN: poses})


@pytest.mark.parametrize(
    "names",
    [
        "mixamorig:Hips mixamorig:LeftUpLeg mixamorig:RightUpLeg mixamorig:LeftLeg "
        "mixamorig:RightLeg mixamorig:LeftFoot mixamorig:RightFoot mixamorig:LeftArm "
        "mixamorig:RightArm mixamorig:LeftForeArm mixamorig:RightForeArm",
        "hips upperleg.l upperleg.r lowerleg.l lowerleg.r foot.l foot.r upperarm.l upperarm.r "
        "lowerarm.l lowerarm.r",
        "Hips UpperLegL UpperLegR LowerLegL LowerLegR FootL FootR UpperArmL UpperArmR LowerArmL "
        "LowerArmR",
        "hip lThigh rThigh lShin rShin lFoot rFoot lShldr rShldr lForeArm rForeArm",
        "pelvis thigh_l thigh_r calf_l calf_r foot_l foot_r upperarm_l upperarm_r lowerarm_l "
        "lowerarm_r",
        "Hips LeftHip RightHip LeftKnee RightKnee LeftAnkle RightAnkle LeftShoulder RightShoulder "
        "LeftElbow RightElbow",
    ],
    ids=["mixamo", "kaykit", "quaternius", "poser", "unreal", "biovision"],
)
def test_joints_are_known_by_the_names_in_use(names: str) -> None:
    listed = names.split()
    skeleton = Skeleton(tuple(listed), (-1,) + (0,) * 10, np.zeros((11, 3)))
    parts = named_parts(skeleton)
    wanted = ("hips", *(part for part in LIMBS for _ in "lr"))
    for number, part in enumerate(wanted):
        side = "" if number == 0 else "left_" if number % 2 else "right_"
        assert parts[side + part] == number


def test_a_skeleton_without_a_leg_is_told_which() -> None:
    skeleton = Skeleton(("Hips", "LeftUpLeg", "RightUpLeg"), (-1, 0, 0), np.zeros((3, 3)))
    with pytest.raises(InvalidInputError, match=r"left upper arm.*There are: Hips, LeftUpLeg"):
        named_parts(skeleton)


def test_a_skeleton_without_length_cannot_be_laid_over_a_body() -> None:
    walk = walking(SPEED)
    flat = Clip(
        "flat",
        replace(walk.skeleton, offsets=np.zeros((15, 3))),
        walk.rate_hz,
        walk.translations,
        walk.rotations,
    )
    with pytest.raises(InvalidInputError, match="no legs of any length"):
        retargeted(flat)
