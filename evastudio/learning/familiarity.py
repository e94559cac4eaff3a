"""How much a moment is like what was demonstrated, against how alike demonstrations are."""

from __future__ import annotations

import numpy as np

from evastudio.learning.holdout import take_folds
from evastudio.learning.learner import Indices
from evastudio.learning.neighbors import NeighborIndex
from evastudio.world.spaces import Array

MOST = 4000
"""So many moments tell how far apart takes are; of more, evenly spaced ones."""


class Familiarity:
    """Tells distances to the nearest demonstration from 1, as near as can be, to 0, far off.

    It is the share of demonstrated moments that are at least as far from all other takes: a
    conformal p-value with the distance to the nearest neighbour as its measure of strangeness
    (Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World, 2005). Moments of a new
    take that is like the others are evenly spread over 0 to 1.
    """

    def __init__(self, states: Array, takes: Indices) -> None:
        """`states` (pairs, n) standardised, `takes` (pairs,) the take that each is from.

        A single take is parted in its middle. Raises InvalidInputError for a single pair.
        """
        if (takes == takes[0]).all():
            takes = (np.arange(len(takes)) >= len(takes) // 2).astype(np.int64)
        every = -(-len(states) // MOST)
        apart = []
        for held in take_folds(takes, 2):
            asked = np.flatnonzero(held)[::every]
            distances, _ = NeighborIndex(states[~held]).nearest(states[asked], 1)
            apart.append(distances[:, 0])
        self._apart = np.sort(np.concatenate(apart))

    def of(self, distances: Array) -> Array:
        """For `distances` (...) to the nearest demonstration, standardised, from 0 to 1."""
        nearer = np.searchsorted(self._apart, distances, side="left")
        return np.asarray((len(self._apart) - nearer + 1) / (len(self._apart) + 1))
