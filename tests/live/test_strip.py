"""What there is to see along a run: how familiar it was, and what happened when."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.records import Origin
from evastudio.live.reel import Reel
from evastudio.live.strip import PLACES, strip_of
from evastudio.pilots.why import Why
from evastudio.world.scene import Scene


def why(familiarity: float) -> Why:
    none = np.zeros(0)
    return Why("one", none.astype(np.int64), None, none, none, None, None, familiarity)


def flown(scene: Scene, seed: int, most: int) -> Reel:
    """Straight on until the world ends."""
    reel = Reel(scene, Origin(0, seed=seed))
    world = scene.worlds([seed])
    reel.add(world)
    while reel.last < most and not scene.outcome(world)[0]:
        world = scene.step(world, np.zeros((1, 2)))
        reel.add(world)
    return reel


def test_a_strip_tells_what_happened_and_when(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=3.0)
    reel = flown(scene, 3, 2000)
    strip = strip_of(reel, reel.moments())
    near, end = strip.happenings[-2:]
    assert (end.kind, end.says, end.seconds) == ("outcome", "hit", strip.length_s)
    assert strip.length_s == pytest.approx(reel.last * scene.dt_s)
    assert near.kind == "near"
    at = round(near.seconds / scene.dt_s)
    assert scene.clearance(reel.moment(at))[0] < scene.near_m
    assert scene.clearance(reel.moment(at - 1))[0] >= scene.near_m


def test_each_part_of_a_strip_is_as_familiar_as_its_strangest_moment(
    asteroids: Callable[..., Scene],
) -> None:
    scene = asteroids(density=0.1)
    reel = flown(scene, 3, 0)
    world = reel.moment(0)
    for step in range(3 * PLACES):
        reel.note(why(1.0 if step != 100 else 0.05) if step < 2 * PLACES else None)
        reel.add(world)
    strip = strip_of(reel, reel.moments())
    assert len(strip.familiarity) == PLACES
    assert [place for place, one in enumerate(strip.familiarity) if one == 0.05] == [100 // 3]
    assert strip.familiarity[-1] is None
    assert strip.familiarity[0] == 1.0
