"""The paving: it lies still under whoever walks on it."""

from __future__ import annotations

import numpy as np

from evastudio.scenery.paving import SLAB, paving_bodies, paving_meshes


def test_it_moves_on_by_whole_slabs() -> None:
    meshes = paving_meshes()
    here, on = (paving_bodies(np.array([x, -3.0])) for x in (0.2, 6.1))
    for before, after in zip(here, on, strict=True):
        assert before.mesh in meshes
        slabs = (after.positions - before.positions) / SLAB
        np.testing.assert_allclose(slabs, np.rint(slabs), atol=1e-9)
    assert abs(float(on[0].positions[0, 0]) - 6.1) <= SLAB
