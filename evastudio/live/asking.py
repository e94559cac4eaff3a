"""Asking a policy: what it would do, and which moments of demonstrations that comes from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.policy import Policy
from evastudio.live.headless import make_scene
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.spaces import Array, Symbols

NOWHERE = -1
"""In place of a take and a step where a policy's file does not tell them."""


@dataclass(frozen=True)
class Sources:
    """Where the decisions for some states come from."""

    takes: NDArray[np.int64]
    """The take of each neighbour, nearest first, (states, k); NOWHERE where it is not known."""
    steps: NDArray[np.int64]
    """Its decision step there, likewise."""
    distances: Array
    """How far its state is, standardised, (states, k)."""
    weights: Array
    """How much it counted, rows summing to 1, (states, k)."""
    agreement: Array | None
    """1 where the neighbours agree, 0 where they differ as all pairs do, (states,)."""


def decide(policy: Policy, states: Array, seed: int | None = None) -> Array:
    """Actions (rows, m) in the character's own frame for states (rows, n).

    A policy that draws takes its luck from `seed`; without one it gives what was shown most often.
    """
    return policy.act_states(states, None if seed is None else np.random.default_rng(seed))


def decide_in_take(
    workspace: Workspace, store: Store, policy: Policy, take: int, steps: NDArray[np.int64]
) -> Array:
    """What a policy would do at moments of a take, in the world's frame, (steps, m).

    Of many characters what the lead would do. Raises NotFoundError, InvalidInputError for steps
    that the take does not have, ConflictError for a policy of another scene.
    """
    record = store.take(take)
    data = store.load_take(take)
    bad = steps[(steps < 0) | (steps >= record.pairs)]
    if bad.size:
        raise InvalidInputError(
            f"Take {take} has no step {int(bad[0])}; its steps are 0 to {record.pairs - 1}."
        )
    scene = make_scene(workspace, store.session(record.session).scene, record.options)
    pilot = PolicyPilot(policy)
    pilot.check(scene)
    moments = data.snapshots.take(steps)
    actions, _ = pilot.act(scene, moments, pilot.begin(scene, [0] * len(steps)))
    return of_lead(moments, actions)


def sources(policy: Policy, states: Array) -> Sources:
    """The moments that decisions for states (rows, n) come from."""
    reasons = policy.explain(states)
    lost = np.full((*reasons.pairs.shape, 2), NOWHERE, dtype=np.int64)
    where = lost if policy.moments is None else policy.moments[reasons.pairs]
    return Sources(
        where[..., 0], where[..., 1], reasons.distances, reasons.weights, reasons.agreement
    )


def symbols_of(policy: Policy, actions: Array) -> list[str] | None:
    """The names of the symbols that `actions` (rows, 1) are; None where they are numbers."""
    if not isinstance(policy.action, Symbols):
        return None
    return [policy.action.names[int(code)] for code in actions[:, 0]]
