"""The ring and the post that show an animator whom they lead, and where to."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.scenery.beacon import POST, beacon_meshes
from evastudio.workspace import shipped
from evastudio.world.cast import led_by
from evastudio.world.loading import load_scene_file


def test_the_ring_lies_flat_and_both_show_their_outsides() -> None:
    ring, post = beacon_meshes()["ring"], beacon_meshes()["post"]
    normals = {}
    for name, mesh in (("ring", ring), ("post", post)):
        a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
        normals[name] = np.cross(b - a, c - a), (a + b + c) / 3
    assert (normals["ring"][0][:, 2] > 0.0).all()
    across, middle = normals["post"]
    assert ((across * (middle - (0.0, 0.0, POST[1] / 2))).sum(axis=1) > 0.0).all()


@pytest.mark.parametrize("name", ["crowd", "street"])
def test_it_is_the_lead_that_has_the_ring(name) -> None:
    scene = load_scene_file(shipped() / "scenes" / f"{name}.py")(people=5)
    world = scene.worlds([3])
    for lead in (0, 4):
        led = led_by(world, lead)
        drawn = {body.name: body.positions for body in scene.bodies(led)}
        np.testing.assert_allclose(drawn["ring"][0, :2], world["position"][0, lead])
        if "goals" in world.fixed:
            np.testing.assert_allclose(drawn["post"][0, :2], world["goals"][0, lead, 0])
