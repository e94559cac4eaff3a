"""Compile everything ahead of time: `python -m evastudio.learning.kernels.warm`.

The studio starts this beside itself, so that nobody waits for a compiler when pressing Play.
"""

from __future__ import annotations

import os

import numpy as np

from evastudio.learning.kernels.tree_search import MANY
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.svr import SVRPolicy
from evastudio.world.compiled import note_compiled
from evastudio.world.kernels import field, rocks  # noqa: F401 - compiled as it is loaded


def warm() -> None:
    """Run every kernel once on a few pairs; what was compiled before is only loaded."""
    rng = np.random.default_rng(0)
    states = rng.normal(size=(MANY, 3))
    actions = states[:, :2]
    index = NeighborIndex(states, "compiled")
    index.nearest_others(5)
    index.median_deviations(actions, 5)
    index.nearest(states, 5)
    index.nearest(states[:1], 5)
    knn = KNNPolicy().fit(states, actions).prepare("compiled")
    whole, compact = (SVRPolicy(bases=bases).fit(states, actions) for bases in (None, 8))
    for learner in (knn, whole, compact):
        learner.decide(states[:1])
        learner.decide(states[:2])
        learner.decide(states)
    note_compiled()


if __name__ == "__main__":
    os.nice(10)
    warm()
