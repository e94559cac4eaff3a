"""What is put into recordings on purpose: random answers, and answers that come late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evastudio.demonstrations.pairs import Pairs


def with_outliers(pairs: Pairs, share: float, rng: np.random.Generator) -> Pairs:
    """`share` of the actions replaced by ones drawn evenly from the range of each component."""
    hit = rng.permutation(len(pairs))[: round(share * len(pairs))]
    low, high = pairs.actions.min(axis=0), pairs.actions.max(axis=0)
    actions = pairs.actions.copy()
    actions[hit] = rng.uniform(low, high, (len(hit), actions.shape[1]))
    return replace(pairs, actions=actions)


def with_delay(pairs: Pairs, steps: int) -> Pairs:
    """Each state with the action that answered the one `steps` earlier in its take.

    The first `steps` states of a take have no such action and are left out.
    """
    if steps == 0:
        return pairs
    late = np.arange(len(pairs)) - steps
    kept = (late >= 0) & (pairs.takes[late] == pairs.takes) & (pairs.steps >= steps)
    return replace(pairs, actions=pairs.actions[late]).keep(kept)
