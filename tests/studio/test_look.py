"""What the asteroid field looks like must not lie about what it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from evastudio.studio.node import checked
from evastudio.world.bodies import Mesh
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene

FIELD = Path(__file__).parents[2] / "scenes" / "asteroids.py"


@pytest.fixture(scope="module")
def field() -> Scene:
    return load_scene_file(FIELD)()


@pytest.fixture(scope="module")
def meshes(field: Scene) -> Mapping[str, Mesh]:
    return field.meshes()


def test_rocks_fill_the_sphere_that_collides_and_stay_within(meshes: Mapping[str, Mesh]) -> None:
    rocks = [mesh for name, mesh in meshes.items() if name.startswith("rock")]
    assert rocks
    for rock in rocks:
        radius = np.linalg.norm(rock.vertices, axis=1)
        assert radius.max() <= 1.0
        assert np.median(radius) > 0.8


def test_meshes_are_sound_and_seen_from_outside(meshes: Mapping[str, Mesh]) -> None:
    for name, mesh in meshes.items():
        assert np.isfinite(mesh.vertices).all(), name
        assert mesh.faces.min() == 0, name
        assert mesh.faces.max() == len(mesh.vertices) - 1, name
        a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() > 0.0, f"{name} is inside out"


def test_the_ship_is_as_large_as_its_hull_and_points_ahead(meshes: Mapping[str, Mesh]) -> None:
    hull = meshes["hull"].vertices
    low, high = hull.min(axis=0), hull.max(axis=0)
    assert 2.0 < high[0] - low[0] < 4.0
    assert high[0] > -low[0]
    assert np.allclose(low[1], -high[1])


def test_everything_of_a_flight_can_be_drawn(field: Scene, meshes: Mapping[str, Mesh]) -> None:
    world = field.worlds([5])
    for _ in range(30):
        world = field.step(world, field.intention(world))
        bodies = field.bodies(world)
        assert len({body.name for body in bodies}) == len(bodies)
        for body in bodies:
            assert body.mesh in meshes
            checked(body)
        camera = field.camera(world)
        behind = world["position"][0] - camera.position
        assert behind @ (camera.look_at - camera.position) > 0.0


def test_rocks_are_where_the_world_has_them(field: Scene) -> None:
    world = field.worlds([8])
    rocks = [body for body in field.bodies(world) if body.name.startswith("rock")]
    drawn = np.concatenate([body.positions for body in rocks])
    assert all(body.fixed for body in rocks)
    assert np.array_equal(np.sort(drawn, axis=0), np.sort(world["rocks"][0], axis=0))
