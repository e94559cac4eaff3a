"""Looking for rocks: plainly and by compiled code, to the same bits."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import numpy as np
import pytest

from evastudio.world.geometry import directions
from evastudio.world.rocks import in_cells, nearest_square, worst_threats
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Rows, Snapshot
from evastudio.world.spaces import Array

HALF = 110.0


def scattered(worlds: int, rocks: int, seed: int) -> Snapshot:
    """Ships anywhere in fields, at their edges and beyond."""
    rng = np.random.default_rng(seed)
    places = rng.uniform((0.0, -HALF, -HALF), (360.0, HALF, HALF), (worlds, rocks, 3))
    position = rng.uniform((-60.0, -170.0, -170.0), (420.0, 170.0, 170.0), (worlds, 3))
    return Snapshot(in_cells(places, 360.0, HALF), {"position": position})


def axes_of(heading: Array) -> tuple[Array, Array, Array]:
    forward = directions(heading)
    left = directions(heading * (1.0, 0.0) + (np.pi / 2, 0.0))
    return forward, left, np.cross(forward, left)


@pytest.mark.parametrize("rocks", [1, 7, 900, 9000])
def test_both_ways_of_looking_see_the_same_bits(rocks: int) -> None:
    snapshot = scattered(200, rocks, rocks)
    for reach in (4.0, 14.0, 60.0):
        plain = nearest_square(snapshot, reach, "plain")
        assert np.array_equal(nearest_square(snapshot, reach, "compiled"), plain)
    heading = np.random.default_rng(1).uniform(-1.05, 1.05, (200, 2))
    heading[::7] = 0.0
    axes = axes_of(heading)
    for radius, sight in ((3.0, 40.0), (1.0, 150.0)):
        plain_threats, there = worst_threats(snapshot, axes, radius, sight, "plain")
        threats, present = worst_threats(snapshot, axes, radius, sight, "compiled")
        assert np.array_equal(threats, plain_threats)
        assert np.array_equal(present, there)
    assert rocks < 900 or there.any()


def test_the_nearest_rock_is_the_nearest() -> None:
    snapshot = scattered(50, 2000, 5)
    apart = snapshot["rocks"] - snapshot["position"][:, None]
    squares = (apart**2).sum(axis=2).min(axis=1)
    for way in ("plain", "compiled"):
        assert nearest_square(snapshot, 700.0, way) == pytest.approx(squares)


def test_worlds_taken_and_moments_of_one_world_see_as_they_do_alone() -> None:
    whole = scattered(40, 3000, 9)
    rows = np.array([3, 3, 39, 0])
    some = whole.take(rows).take(np.array([True, False, True, True]))
    assert isinstance(some.fixed, Rows)
    rocks = whole.fixed["rocks"][:1]
    moments = Snapshot(
        {
            name: np.broadcast_to(array[:1], (40, *array.shape[1:]))
            for name, array in whole.fixed.items()
        },
        whole.moving,
    )
    repeated = Snapshot({**in_cells(np.repeat(rocks, 40, axis=0), 360.0, HALF)}, whole.moving)
    for way in ("plain", "compiled"):
        everywhere = nearest_square(whole, 30.0, way)
        assert np.array_equal(nearest_square(some, 30.0, way), everywhere[[3, 39, 0]])
        alone = nearest_square(repeated, 30.0, way)
        assert np.array_equal(nearest_square(moments, 30.0, way), alone)


def test_what_is_taken_is_copied_only_when_asked_for() -> None:
    whole = scattered(6, 10, 2)
    some = whole.take(np.array([4, 1]))
    assert np.array_equal(some["rocks"], whole["rocks"][[4, 1]])
    assert some.fixed.keys() == whole.fixed.keys()
    sent = pickle.loads(pickle.dumps(some))
    assert type(sent.fixed) is dict
    assert np.array_equal(sent["cells"], some["cells"])


def test_a_field_looks_the_same_to_many_as_to_few(asteroids: Callable[..., Scene]) -> None:
    """Few worlds are looked at plainly, many by compiled code."""
    scene = asteroids(density=6.0)
    many = scene.worlds(range(20)).after(
        position=np.random.default_rng(0).uniform((30, -90, -90), (330, 90, 90), (20, 3))
    )
    for number in range(20):
        one = many.take(slice(number, number + 1))
        assert np.array_equal(scene.clearance(one)[0], scene.clearance(many)[number])
        seen = scene.perception().perceive
        assert np.array_equal(seen(one).states[0], seen(many).states[number])
