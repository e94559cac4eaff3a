"""Does the state repeat the action? Then a policy looks perfect on paper and stalls in the loop.

Learning that the next action is like the last foretells held-out takes almost exactly, and says
nothing of why: once it acts alone, such a policy repeats itself (de Haan, Jayaraman, Levine,
"Causal confusion in imitation learning", 2019).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.finding import Finding, plain
from evastudio.world.spaces import Array

REPEATS = 0.9
"""A component repeats the action before it where it shares this much of its variance, and more
than with the action that answers it. In the asteroid field it is at most 0.3; in Push-T, where
the hand follows the target at once, 0.99."""
IS = 0.98
"""And is the action itself where it shares this much with that: nobody answers so exactly."""


def find_copies(pairs: Pairs, state: Sequence[str]) -> Finding:
    """Which components of the state repeat a component of the action.

    `state` names the former. The measure is the largest share of variance.
    """
    before = np.flatnonzero((np.diff(pairs.takes) == 0) & (np.diff(pairs.steps) == 1))
    copied, most = repeating(
        pairs.states[before + 1], pairs.actions[before], pairs.actions[before + 1]
    )
    names = [state[row] for row in map(int, np.flatnonzero(copied.any(axis=1)))]
    if not names:
        return Finding("copies", False, most, "Nothing in the state merely repeats the action.")
    listed = " and ".join(f"“{plain(name)}”" for name in names[:2])
    more = f" and {len(names) - 2} more" if len(names) > 2 else ""
    sentence = (
        f"In the state {listed}{more} all but repeat the action: a policy can look perfect on "
        "takes it has not seen and still stall when it acts alone. Judge it by letting it play, "
        "or use a perception without them."
    )
    return Finding("copies", True, most, sentence, {"components": names})


def repeating(states: Array, before: Array, now: Array) -> tuple[NDArray[np.bool_], float]:
    """Which components of `states` (pairs, n) repeat the actions `before` or `now` (pairs, m).

    Shape (n, m), and the largest share of variance.
    """
    last, same = shared_variance(states, before), shared_variance(states, now)
    copied = ((last >= REPEATS) & (last > same)) | (same >= IS)
    return copied, float(np.maximum(last, same).max(initial=0.0))


def shared_variance(states: Array, actions: Array) -> Array:
    """Squared correlation of each component of states (pairs, n) with each of actions (pairs, m).

    Shape (n, m); 0 where one of them does not change.
    """
    if len(states) < 3:
        return np.zeros((states.shape[1], actions.shape[1]))
    apart = [values - values.mean(axis=0) for values in (states, actions)]
    sizes = [np.sqrt((values**2).sum(axis=0)) for values in apart]
    scale = sizes[0][:, None] * sizes[1][None, :]
    together = apart[0].T @ apart[1]
    return np.asarray(np.where(scale > 1e-12, together / np.maximum(scale, 1e-300), 0.0) ** 2)
