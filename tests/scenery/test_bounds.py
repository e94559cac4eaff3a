"""The walls of a corridor: they are where it ends, and near enough to each other to be seen."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.scenery.bounds import APART, WIDE, bar_mesh, bounds
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file


def test_a_bar_is_a_cube_seen_from_outside() -> None:
    mesh = bar_mesh()
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    outward = np.cross(b - a, c - a)
    assert ((outward * (a + b + c)).sum(axis=1) > 0.0).all()
    assert np.abs(mesh.vertices).max() == np.abs(mesh.vertices).min() == 0.5
    assert np.linalg.norm(outward, axis=1).sum() / 2 == pytest.approx(6.0)


@pytest.mark.parametrize("half_width", [30.0, 100.0, 150.0])
def test_the_fields_walls_are_drawn_where_one_leaves_it(half_width: float) -> None:
    scene = load_scene_file(shipped() / "scenes" / "asteroids.py")(half_width=half_width)
    world = scene.worlds([3])
    (walls,) = [body for body in scene.bodies(world) if body.name == "bounds"]
    assert walls.mesh in scene.meshes()
    assert walls.fixed
    aside = np.abs(walls.positions[:, 1:]).max(axis=1)
    np.testing.assert_allclose(aside, half_width)
    inside, outside = (
        world.after(position=np.array([(100.0, half_width + over, 0.0)])) for over in (-WIDE, WIDE)
    )
    assert scene.outcomes[int(scene.outcome(inside)[0])] != "left"
    assert scene.outcomes[int(scene.outcome(outside)[0])] == "left"


def test_wherever_one_comes_to_a_wall_a_bar_is_near() -> None:
    walls = bounds(360.0, 90.0)
    rng = np.random.default_rng(5)
    for x, z in rng.uniform((0.0, -90.0), (360.0, 90.0), (50, 2)):
        away = np.abs(np.array([x, 90.0, z]) - walls.positions) - np.asarray(walls.scales) / 2
        nearest = np.linalg.norm(np.maximum(away, 0.0), axis=1).min()
        assert nearest <= APART / 2
