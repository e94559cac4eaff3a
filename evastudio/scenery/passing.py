"""How people who walk freely get along: what their walk comes to, in figures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from evastudio.world.snapshot import Snapshot

TOUCH = 0.3
"""Metres between the middles of two people below which they touch."""


def touches(moments: Snapshot) -> NDArray[np.int64]:
    """How often each of those there comes to touch somebody, (N,); `moments` of one world."""
    touching = np.zeros((moments.worlds + 1, moments["present"].shape[1]), dtype=np.bool_)
    for moment, (position, present) in enumerate(
        zip(moments["position"], moments["present"] > 0, strict=True), start=1
    ):
        if present.sum() > 1:
            there = position[present]
            far = KDTree(there).query(there, k=2)[0][:, 1]
            touching[moment, present] = far < TOUCH
    return np.asarray((touching[1:] & ~touching[:-1]).sum(axis=0))


def detour(moments: Snapshot, reach: float) -> float:
    """Metres walked for each metre straight from goal to goal, mean over those who reached any.

    `moments` of one world from its beginning; a goal is reached `reach` metres from it. NaN where
    nobody reached one.
    """
    position, leg = moments["position"], moments["leg"]
    steps = np.diff(position, axis=0)
    walked = np.concatenate([np.zeros((1, len(leg[0]))), np.hypot(*np.moveaxis(steps, 2, 0))])
    goals = moments["goals"][0]
    turns = np.concatenate([position[0][:, None], goals], axis=1)
    straight = np.hypot(*np.moveaxis(np.diff(turns, axis=1), 2, 0)).cumsum(axis=1)
    shares = []
    for who, reached in enumerate(np.minimum(leg[-1], goals.shape[1])):
        if reached and straight[who, reached - 1] > reach:
            arrives = int((leg[:, who] >= reached).argmax())
            way = walked[: arrives + 1, who].sum()
            shares.append(way / (straight[who, reached - 1] - reach))
    return float(np.mean(shares)) if shares else float("nan")
