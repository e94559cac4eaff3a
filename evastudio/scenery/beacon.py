"""Which of many an animator leads, and where that one should go: a ring around it, and a post."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from evastudio.world.bodies import Body, Mesh
from evastudio.world.spaces import Array

ORANGE = (255, 138, 66)
SIDES = 40
RING = (0.36, 0.45)
"""Metres from its middle to its inner and outer edge."""
POST = (0.07, 2.6)
"""Half its width and its height, metres: it is seen above heads."""
LIFT = 0.012
"""Metres of the ring above the ground, so that paving and shadows do not cover it."""
LEVEL = np.array([(1.0, 0.0, 0.0, 0.0)])


@lru_cache(maxsize=1)
def beacon_meshes() -> dict[str, Mesh]:
    """The ring and the post."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)], axis=1)
    inner = np.arange(SIDES)
    on = (inner + 1) % SIDES
    outer, beyond = inner + SIDES, on + SIDES
    faces = np.concatenate([np.stack([inner, outer, beyond], 1), np.stack([inner, beyond, on], 1)])
    ring = Mesh(np.concatenate([edge * circle for edge in RING]), faces, ORANGE, glow=True)
    wide, high = POST
    foot = wide * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float64)
    top = foot + np.array([0.0, 0.0, high])
    walls = [
        three
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
        for three in ((a, b, b + 4), (a, b + 4, a + 4))
    ]
    lid = [(4, 5, 6), (4, 6, 7)]
    post = Mesh(np.concatenate([foot, top]), np.array([*walls, *lid]), ORANGE, glow=True)
    return {"ring": ring, "post": post}


def ring_body(here: Array) -> Body:
    """The ring around who is led, at `here` (2,)."""
    return Body("ring", "ring", np.array([(*here, LIFT)]), LEVEL, np.ones(1))


def post_body(there: Array) -> Body:
    """The post at the place to go to, `there` (2,)."""
    return Body("post", "post", np.array([(*there, 0.0)]), LEVEL, np.ones(1))
