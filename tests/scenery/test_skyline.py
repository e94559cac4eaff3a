"""The houses in the haze: around whoever looks, and seen from inside the ring they make."""

from __future__ import annotations

import numpy as np

from evastudio.scenery.skyline import FAR, NEAR, skyline_body, skyline_mesh


def test_houses_stand_on_the_ground_far_off_and_are_not_inside_out() -> None:
    mesh = skyline_mesh()
    far = np.hypot(*mesh.vertices[:, :2].T)
    assert mesh.vertices[:, 2].min() == 0.0
    assert NEAR - 10.0 < far.min() < far.max() < FAR + 15.0
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    house = (
        mesh.vertices.reshape(-1, 8, 3)
        .mean(axis=1)
        .repeat(len(mesh.faces) * 8 // len(mesh.vertices), 0)
    )
    outwards = (a + b + c) / 3 - house
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), outwards) > 0.0).all()


def test_they_come_along() -> None:
    body = skyline_body(np.array([3.0, -2.0]))
    assert body.positions.tolist() == [[3.0, -2.0, 0.0]]
