"""What lies behind a scene: a sky down to the horizon, or the same distance all around."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evastudio.studio.air import backdrop, horizon
from evastudio.world.bodies import Look

HAZE = Look((220, 220, 210), 20.0, 100.0, (0.0, 0.0, 1.0))


def test_the_horizon_is_where_a_level_ray_goes() -> None:
    assert horizon((0.0, 0.0, 2.0), (5.0, 0.0, 2.0)) == pytest.approx(0.5)
    down = 5.0 * np.tan(np.radians(30.0))
    assert horizon((0.0, 0.0, down), (3.0, 4.0, 0.0)) == pytest.approx(0.0)
    assert horizon((0.0, 0.0, 9.0), (0.0, 0.0, 0.0)) == 0.0
    assert horizon((0.0, 0.0, 0.0), (0.0, 1.0, 9.0)) == 1.0


@pytest.mark.parametrize("at", [0.0, 0.2, 1.0])
def test_the_sky_pales_down_to_the_horizon(at: float) -> None:
    sky = backdrop(replace(HAZE, zenith=(90, 150, 210)), at).astype(int)
    below = sky[round(at * len(sky)) + 1 :]
    assert np.abs(below - HAZE.background).max(initial=0) <= 1
    red = sky[:, 0, 0]
    assert (np.diff(red) >= -1).all()
    assert at == 0.0 or red[0] < 100


def test_without_a_sky_the_distance_has_its_colour_in_the_middle() -> None:
    seen = backdrop(HAZE)
    assert np.abs(seen[len(seen) // 2, seen.shape[1] // 2].astype(int) - HAZE.background).max() <= 1
    assert seen[0, 0, 0] < HAZE.background[0]
