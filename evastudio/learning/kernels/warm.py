"""Compile everything ahead of time: `python -m evastudio.learning.kernels.warm`.

The studio starts this beside itself, so that nobody waits for a compiler when pressing Play.
"""

from __future__ import annotations

import os

import numpy as np

from evastudio.learning.conflicts import ConflictEliminator
from evastudio.learning.kernels.tree_search import MANY
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.svr import SVRPolicy


def warm() -> None:
    """Run every kernel once on a few pairs; what was compiled before is only loaded."""
    rng = np.random.default_rng(0)
    states = rng.normal(size=(MANY, 3))
    actions = states[:, :2]
    ConflictEliminator().fit(states, actions)
    for learner in (KNNPolicy(), SVRPolicy(bases=8), SVRPolicy()):
        learner.fit(states, actions)
        learner.decide(states[:1])
        learner.decide(states[:2])
        learner.decide(states)


if __name__ == "__main__":
    os.nice(10)
    warm()
