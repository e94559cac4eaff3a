"""Signs: what a scene tells of a character, for switches to hang on."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")


def told(scene, snapshot, name):
    """That sign, (worlds, N)."""
    return scene.notice(snapshot)[:, :, [sign.name for sign in scene.signs].index(name)]


def test_the_boulder_is_falling_and_then_has_hit() -> None:
    scene = CROWD(people=5, side=9)
    snapshot = scene.worlds([1])
    rest = np.zeros((1, 5, 6))
    drop = rest.copy()
    drop[:, 0, 2:5] = 1.0, 2.0, 3.0
    seen = []
    for actions in (rest, drop, rest, rest, rest):
        snapshot = scene.step(snapshot, actions)
        seen.append((told(scene, snapshot, "falling")[0, 3], told(scene, snapshot, "impact")[0, 3]))
    assert seen == [(0, 0), (1, 0), (1, 0), (0, 1), (0, 1)]
    assert np.array_equal(told(scene, snapshot, "hit"), snapshot["hit"])


def test_places_and_distances_know_that_the_ground_has_no_edge() -> None:
    scene = CROWD(people=2, side=10)
    snapshot = scene.worlds([1])
    assert (told(scene, snapshot, "boulder") == 1e6).all()
    far = np.array([[[7.0 * 5 + 0.7, -0.7], [0.7, 1.4]]])
    snapshot = snapshot.after(position=far, boulder=np.array([[-0.7, 0.0, 0.5]]))
    assert told(scene, snapshot, "x")[0] == pytest.approx([0.7, 0.7])
    assert told(scene, snapshot, "y")[0] == pytest.approx([6.3, 1.4])
    assert told(scene, snapshot, "boulder")[0, 0] == pytest.approx(np.hypot(1.4, 0.7))
    struck = snapshot.after(boulder=np.array([[-0.7, 0.0, 2.0]]))
    assert told(scene, struck, "boulder")[0, 0] == pytest.approx(np.hypot(36.4, 0.7))
