"""Light and dark: how a scene looks to somebody who has the page in the one or the other.

A scene has one look. Where that is bright and the page is dark, it is seen at dusk; where it is
dark and the page is light, in a haze; else as it is. So words over the view have the same ground as
the rest of the page.
"""

from __future__ import annotations

from dataclasses import replace
from enum import StrEnum

from evastudio.studio.air import linear
from evastudio.world.bodies import Color, Look

BRIGHT = 0.2
"""Luminance of a distance, 0 to 1, from which on a scene is a bright one."""
HAZE, WHITE = (222, 229, 241), (255, 255, 255)
DUSK, NIGHT, MOON = (38, 46, 74), (12, 17, 34), (132, 156, 226)


class Scheme(StrEnum):
    """What the page is in."""

    LIGHT = "light"
    DARK = "dark"


def seen_in(look: Look, scheme: Scheme | None) -> Look:
    """`look` to somebody whose page is in `scheme`; as it is where that is None."""
    bright = luminance(look.background) > BRIGHT
    if scheme is None or bright == (scheme is Scheme.LIGHT):
        return look
    if bright:
        return replace(
            look,
            background=blend(look.background, DUSK, 0.92),
            zenith=None if look.zenith is None else blend(look.zenith, NIGHT, 0.9),
            sun=0.42 * look.sun,
            sky=0.5 * look.sky,
            sun_color=blend(look.sun_color, MOON, 0.4),
            sky_color=blend(look.sky_color, MOON, 0.6),
            ground_color=blend(look.ground_color, NIGHT, 0.5),
        )
    return replace(
        look,
        background=blend(look.background, HAZE, 0.92),
        zenith=None if look.zenith is None else blend(look.zenith, HAZE, 0.7),
        sky=1.5 * look.sky,
        sun_color=blend(look.sun_color, WHITE, 0.5),
        sky_color=blend(look.sky_color, WHITE, 0.7),
        ground_color=blend(look.ground_color, HAZE, 0.7),
    )


def luminance(color: Color) -> float:
    """How bright, 0 to 1 (WCAG 2, relative luminance)."""
    r, g, b = linear(color)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def blend(color: Color, other: Color, share: float) -> Color:
    """`color` with so large a share of `other`."""
    r, g, b = (round(a + (b - a) * share) for a, b in zip(color, other, strict=True))
    return r, g, b
