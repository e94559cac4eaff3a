"""What a workspace chose reaches every scene that people walk in, and no other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.live.clips import add_clips, choose_clip, clips, dress, forget_clip
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot
from evastudio.motion.figures import figures
from evastudio.motion.library import CHOICES
from evastudio.motion.moment import Moment
from evastudio.motion.peopled import Peopled
from evastudio.motion.sliding import steps_cm
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot
from tests.motion.walker import bvh, glb, walking

PEOPLE = {"people": 5.0}


def crowd(workspace: Workspace) -> Peopled:
    scene = make_scene(workspace, "crowd", PEOPLE)
    assert isinstance(scene, Peopled)
    return scene


def limbs(scene: Peopled) -> np.ndarray:
    world = scene.worlds([3])
    ones = np.ones((1, 5))
    walked = world.after(speed=1.4 * ones, phase=0.3 * ones, cadence=ones)
    return np.concatenate([body.wxyzs for body in scene.bodies(walked) if "figure" in body.name])


def drawn(scene: Peopled, pilot: Pilot, steps: int, seed: int = 5) -> Iterator[Moment]:
    """What is drawn of a crowd, 30 moments a second."""
    world, memory = scene.worlds([seed]), pilot.begin(scene, [seed])
    for _ in range(steps):
        actions, memory = pilot.act(scene, world, memory)
        after = scene.step(world, actions)
        for share in np.arange(1, 16) / 15:
            yield scene.moment(scene.interpolate(world, after, float(share)))  # type: ignore[attr-defined]
        world = after


def test_people_walk_as_was_chosen_and_again_as_shipped(workspace: Workspace) -> None:
    add_clips(workspace, "odd walk.bvh", bvh(walking(0.7)).encode())
    shipped = limbs(crowd(workspace))
    told = choose_clip(workspace, "walk", "odd walk.bvh")
    assert told["activities"][1] == {
        "name": "walk",
        "label": "Walk",
        "file": "odd walk.bvh",
        "clip": "odd walk",
        "problem": None,
    }
    chosen = crowd(workspace)
    assert chosen.figures is crowd(workspace).figures
    assert np.abs(limbs(chosen) - shipped).max() > 0.05
    forget_clip(workspace, "walk")
    assert crowd(workspace).figures is figures()


def test_what_happens_in_a_world_does_not_depend_on_the_clips(workspace: Workspace) -> None:
    before = crowd(workspace)
    add_clips(workspace, "hero.glb", glb(walking(0.7)))
    choose_clip(workspace, "walk", "hero.glb", "walk")
    after = crowd(workspace)
    world = before.worlds([3])
    actions = before.intention(world)
    first, second = before.step(world, actions), after.step(world, actions)
    for name, array in first.moving.items():
        np.testing.assert_array_equal(array, second.moving[name])


def test_a_choice_that_has_gone_is_told_and_people_still_walk(workspace: Workspace) -> None:
    add_clips(workspace, "hero.glb", glb(walking(1.2)))
    choose_clip(workspace, "run", "hero.glb", "walk")
    (workspace.motion / "hero.glb").unlink()
    assert crowd(workspace).figures is figures()
    run = next(one for one in clips(workspace)["activities"] if one["name"] == "run")
    assert "hero.glb" in run["problem"]


def test_damaged_choices_are_told_and_people_still_walk(workspace: Workspace) -> None:
    workspace.motion.mkdir()
    (workspace.motion / CHOICES).write_text("{")
    assert crowd(workspace).figures is figures()
    assert "cannot be read" in clips(workspace)["problem"]


def test_a_file_of_several_clips_asks_which(workspace: Workspace) -> None:
    add_clips(workspace, "hero.glb", glb(walking(1.2), "walk", "run"))
    with pytest.raises(InvalidInputError, match="has 2 clips: walk, run"):
        choose_clip(workspace, "walk", "hero.glb")


def test_a_scene_without_people_is_left_alone(workspace: Workspace) -> None:
    scene = make_scene(workspace, "asteroids")
    dress(scene, workspace)
    assert not hasattr(scene, "figures")


@pytest.mark.parametrize("clip", [None, "odd.bvh"], ids=["shipped", "imported"])
@pytest.mark.parametrize("pilot", ["scripted:hurried", "scripted:shy", "scripted:startled"])
def test_feet_do_not_slide_in_the_crowd(workspace: Workspace, pilot: str, clip: str | None) -> None:
    if clip is not None:
        add_clips(workspace, clip, bvh(walking(0.9)).encode())
        choose_clip(workspace, "walk", clip)
    scene = make_scene(workspace, "crowd", {"people": 25.0, "side": 20.0})
    assert isinstance(scene, Peopled)
    moments = drawn(scene, load_pilot(workspace, pilot, scene), steps=24)
    slid = steps_cm(scene.figures, moments, scene.worlds([5])["size"][0])
    assert len(slid) > 200
    assert slid.mean() < 1.5
    assert np.quantile(slid, 0.99) < 3.0
