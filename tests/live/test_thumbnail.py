"""Thumbnails show the way of a take, what stood near it, and how it ended."""

from __future__ import annotations

import re
from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pytest

from evastudio.demonstrations.records import TakeData
from evastudio.live.thumbnail import BAD, GOOD, HEIGHT, OPEN, OTHER, THING, WIDTH, thumbnail
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene
from evastudio.world.snapshot import stack
from evastudio.world.spaces import Array

SVG = "{http://www.w3.org/2000/svg}"


def gone(scene: Scene, actions: Array) -> TakeData:
    moments = [scene.worlds([3])]
    for action in actions[:-1]:
        moments.append(scene.step(moments[-1], action[None]))
    return TakeData(stack(moments), np.zeros((len(actions), 1)), actions)


def way(svg: bytes) -> np.ndarray:
    points = re.search(rb'points="([^"]+)"', svg)
    assert points is not None
    return np.array([point.split(b",") for point in points[1].split()], dtype=float)


def drawn(svg: bytes, colour: str) -> int:
    """How many circles there are in the group of that colour."""
    groups = ElementTree.fromstring(svg).findall(f"{SVG}g[@fill='{colour}']")
    return sum(len(group) for group in groups)


def test_the_way_is_drawn_among_rocks(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=2.0)
    left = np.tile([scene.action.high[0], 0.0], (12, 1))
    data = gone(scene, np.concatenate([np.zeros((220, 2)), left, np.zeros((220, 2))]))
    svg = thumbnail(scene, data, "hit")
    points = way(svg)
    assert (points > 0.0).all()
    assert (points < [WIDTH, HEIGHT]).all()
    assert (np.diff(points[:, 0]) >= 0.0).all()  # on, to the right
    assert points[-1, 1] < points[0, 1] - 5.0  # to the left, which is up
    assert drawn(svg, THING) > 3
    assert drawn(svg, OTHER) == 0
    assert BAD.encode() in svg
    assert GOOD.encode() in thumbnail(scene, data, "crossed")
    assert OPEN.encode() in thumbnail(scene, data, None)
    assert len(svg) < 10_000


def test_one_moment_is_a_thumbnail_too(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids()
    points = way(thumbnail(scene, gone(scene, np.zeros((1, 2))), None))
    assert points == pytest.approx(np.array([[WIDTH / 2.0, HEIGHT / 2.0]]))


def test_the_others_of_a_crowd_are_dots() -> None:
    scene = load_scene_file(shipped() / "scenes" / "crowd.py")(people=20, side=15)
    moments = [scene.worlds([3])]
    ahead = scene.action.clip(np.ones((1, 20, scene.action.size)))
    for _ in range(6):
        moments.append(scene.step(moments[-1], ahead))
    data = TakeData(stack(moments), np.zeros((7, 1)), np.repeat(ahead, 7, axis=0))
    svg = thumbnail(scene, data, None)
    assert 0 < drawn(svg, OTHER) < 20
    assert len(svg) < 10_000
