"""Pairs of a scripted steering character, as many as wanted: what the other benchmarks record is
too little to ask how costs grow.
"""

from __future__ import annotations

import numpy as np

from evastudio.world.spaces import Array

MOMENTS = 600
"""Decisions in a row in one world."""


def steered(pairs: int, seed: int) -> tuple[Array, Array]:
    """States (pairs, 8) and actions (pairs, 2) of characters that keep north and evade.

    In each of many worlds a character passes two moving obstacles, moment by moment. A state is
    its heading, and of each obstacle the bearing times its nearness, and the distance; an action
    is a turn, with a little tremor, and a speed. Other seeds are other worlds.
    """
    rng = np.random.default_rng(seed)
    worlds = max(1, pairs // MOMENTS)
    moments = -(-pairs // worlds)
    states = np.empty((moments, worlds, 8), np.float32)
    actions = np.empty((moments, worlds, 2), np.float32)
    heading = rng.uniform(-np.pi, np.pi, worlds)
    places = rng.uniform(-20.0, 20.0, (worlds, 2, 2))
    speeds = rng.normal(size=(worlds, 2, 2))
    for moment in range(moments):
        away = np.hypot(places[..., 0], places[..., 1])
        bearing = np.arctan2(places[..., 1], places[..., 0]) - heading[:, None]
        near = np.exp(-away / 10.0)
        turn = rng.normal(-0.3 * np.sin(heading), 0.05)
        turn -= (near * np.sign(np.sin(bearing)) * (np.cos(bearing) > 0.0)).sum(axis=1)
        speed = 1.0 - 0.5 * near.max(axis=1)
        ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        seen = [ahead, near * np.cos(bearing), near * np.sin(bearing), away / 20.0]
        states[moment] = np.concatenate(seen, axis=1)
        actions[moment] = np.stack([turn, speed], axis=1)
        heading = heading + 0.2 * turn
        places += 0.3 * (speeds - (ahead * speed[:, None])[:, None])
        gone = np.hypot(places[..., 0], places[..., 1]) > 25.0
        places[gone] = rng.uniform(-20.0, 20.0, (int(gone.sum()), 2))
        speeds[gone] = rng.normal(size=(int(gone.sum()), 2))
    return (
        states.reshape(-1, 8)[:pairs].astype(np.float64),
        actions.reshape(-1, 2)[:pairs].astype(np.float64),
    )
