"""Conflicts between two pairs, as the paper defines them (eq. 2), listed on demand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from evastudio.errors import InvalidInputError
from evastudio.learning.neighbors import Indices
from evastudio.learning.scaling import Scaling
from evastudio.world.spaces import finite_rows

BLOCK = 1024
"""Pairs whose surroundings are looked through together, to bound memory."""


def pairwise_conflicts(
    states: Any, actions: Any, near: float, apart: float
) -> Iterator[tuple[Indices, Indices]]:
    """Numbers i < j of two pairs whose states are close and whose actions are not (eq. 2).

    states (pairs, n) are standardised first, and `near` is a distance between them; `apart` is a
    distance between actions (pairs, m) or (pairs,), each component as a share of its observed
    range. There can be as many as pairs times pairs: they come some at a time, as arrays of one
    length, in the order of i, and whoever has seen enough stops.
    Raises InvalidInputError for NaN, shapes that do not fit, and distances below 0.
    """
    seen = np.asarray(states, dtype=np.float64)
    seen = finite_rows(seen, seen.shape[-1] if seen.ndim == 2 else 1, "states")
    done = np.asarray(actions, dtype=np.float64)
    done = done.reshape(-1, 1) if done.ndim == 1 else done
    done = finite_rows(done, done.shape[-1], "actions")
    if len(seen) != len(done):
        raise InvalidInputError(
            f"There are {len(seen)} states and {len(done)} actions; every state needs one action."
        )
    if not (near >= 0 and apart >= 0):
        raise InvalidInputError(
            f"near is {near} and apart is {apart}; both are distances, from 0 on."
        )
    return _conflicts(Scaling.of(seen).apply(seen), done, near, apart)


def _conflicts(
    points: Any, actions: Any, near: float, apart: float
) -> Iterator[tuple[Indices, Indices]]:
    span = np.ptp(actions, axis=0)
    shares = actions / np.where(span > 0, span, 1.0)
    tree = cKDTree(points)
    for at in range(0, len(points), BLOCK):
        around = tree.query_ball_point(points[at : at + BLOCK], near, return_sorted=True)
        first = np.repeat(np.arange(at, at + len(around)), [len(found) for found in around])
        second = np.concatenate([np.asarray(found, dtype=np.int64) for found in around])
        later = second > first
        first, second = first[later], second[later]
        far = np.linalg.norm(shares[first] - shares[second], axis=1) > apart
        far &= np.linalg.norm(points[first] - points[second], axis=1) < near
        if far.any():
            yield first[far], second[far]
