"""A scene to somebody whose page is light, and to somebody whose page is dark."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evastudio.studio.scheme import Scheme, luminance, seen_in
from evastudio.world.bodies import Look

BRIGHT = Look((226, 224, 214), 20.0, 100.0, (0.0, 0.0, 1.0), zenith=(92, 148, 206))
DARK = Look((34, 45, 82), 20.0, 100.0, (0.0, 0.0, 1.0))


@pytest.mark.parametrize("look", [BRIGHT, DARK, replace(DARK, zenith=(9, 12, 30))])
def test_the_distance_is_as_bright_as_the_page(look: Look) -> None:
    light, dark = (seen_in(look, scheme) for scheme in (Scheme.LIGHT, Scheme.DARK))
    assert luminance(light.background) > 0.5
    assert luminance(dark.background) < 0.06
    assert dark.sky < light.sky
    if look.zenith is not None:
        assert luminance(dark.zenith or (255, 255, 255)) < luminance(light.zenith or (0, 0, 0))


def test_a_scene_that_suits_is_shown_as_it_is() -> None:
    assert seen_in(BRIGHT, Scheme.LIGHT) is BRIGHT
    assert seen_in(DARK, Scheme.DARK) is DARK
    assert seen_in(DARK, None) is DARK


def test_what_the_scene_says_of_its_air_stays() -> None:
    for look in (BRIGHT, DARK):
        for scheme in Scheme:
            seen = seen_in(look, scheme)
            assert (seen.fog_near, seen.fog_far) == (look.fog_near, look.fog_far)
            assert seen.sun_direction == look.sun_direction
