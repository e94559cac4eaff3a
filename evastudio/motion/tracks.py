"""Tracks: where the feet of mixed gaits go, as one walks an arc or as they stand on the ground."""

from __future__ import annotations

import numpy as np

from evastudio.motion.easing import smooth
from evastudio.motion.moment import Moment
from evastudio.motion.rotations import Numbers, components, joined, normalized, product
from evastudio.motion.table import (
    ANKLES,
    ASIDE,
    DUTIES,
    HINGES,
    PLACES,
    ROOT,
    STROKES,
    TURNS,
    Floats,
)

RISING = 0.1
"""Share of its way to the next step after which a foot need not be reached any more."""


def on_arc(
    table: Floats, strides: Floats, turns: Floats
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Where the track under each foot is, x and y, and cosine and sine of half its turn, (2, N).

    `strides` (N,) and `turns` (N,) are metres at size 1 and radians a cycle. The straight track
    on which the feet were laid is bent into the circle that the character walks, and stretched
    to its stride: a foot that stands then stands still on the ground, whatever the speed.
    """
    strokes = table[STROKES]
    half = turns * strokes / 2
    c, s = np.cos(half), np.sin(half)
    chord = strokes * strides * np.where(np.abs(half) > 1e-4, s / np.where(half == 0, 1, half), 1)
    return chord * c, chord * s, c, s


def on_ground(
    table: Floats, moment: Moment, walking: Floats, upright: Floats
) -> tuple[tuple[Numbers, Numbers, Numbers, Numbers], Numbers]:
    """The same where a `footing` is given, and how much each foot stands, 0 to 1, (2, N).

    `walking` and `upright` (N,) tell how far each walks, and how far each is on the feet at all:
    those of who lies move with the body.
    """
    assert moment.footing is not None
    stood, aims = (np.moveaxis(feet, 0, -1) for feet in (moment.footing.stood, moment.footing.aims))
    duties = np.where(walking > 0.01, table[DUTIES] / np.maximum(walking, 0.01), 0.6)
    phases = np.mod(moment.phases - np.array([[0.0], [0.5]]), 1.0)
    swing = np.clip((phases - duties) / (1 - duties), 0.0, 1.0)
    # As `gait.stroke`, seen from the ground: feet leave and arrive at rest.
    slope = swing * (1 - swing) * (1 - 2 * swing) * (1 - duties)
    share = duties * swing * swing * (3 - 2 * swing) + (1 - duties) * swing - slope
    track = stood + (aims - stood) * share[:, None]
    away = (track[:, :2] - moment.positions.T[:2]) * (upright / moment.sizes)
    c, s = np.cos(moment.headings), np.sin(moment.headings)
    x, y = c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]
    half = (track[:, 2] - moment.headings) * (upright / 2)
    held = upright * smooth(1 - share / RISING)
    x, y, c, s, held = (
        part.astype(np.float32) for part in (x, y, np.cos(half), np.sin(half), held)
    )
    return (x, y, c, s), held


def settle(table: Floats) -> None:
    """Change mixed rows, in place, so that feet stand at one place of their tracks in all of them.

    A foot that stands would slide as one row takes over from another; the body does so instead.
    """
    ahead = table[PLACES][::2]
    table[ROOT.start] -= ahead.mean(axis=0)
    table[ANKLES.start : ANKLES.stop : 3] -= ahead
    aside = np.array([[ASIDE], [-ASIDE]], dtype=np.float32)
    table[ANKLES.start + 1 : ANKLES.stop : 3] += aside - table[PLACES][1::2]


def stepped(
    table: Floats, x: Numbers, y: Numbers, c: Numbers, s: Numbers
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Upper rotations, ankles, feet and hinges of mixed rows, with feet on their tracks."""
    count = table.shape[1]
    rotations = normalized(np.moveaxis(table[TURNS].reshape(11, 4, count), 1, -1))
    hinges = np.moveaxis(table[HINGES].reshape(2, 3, count), 1, -1)
    ahead, aside, up = np.moveaxis(table[ANKLES].reshape(2, 3, count), 1, 0)
    cos, sin = c * c - s * s, 2 * s * c
    ankles = joined(x + cos * ahead - sin * aside, y + sin * ahead + cos * aside, up)
    zero = np.zeros_like(c)
    feet = product(joined(c, zero, zero, s), rotations[9:11])
    hx, hy, hz = components(hinges)
    return rotations[:9], ankles, feet, joined(c * hx - s * hy, s * hx + c * hy, hz)
