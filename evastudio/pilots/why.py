"""Why a character did that: the demonstrated moments a decision came from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from evastudio.errors import NotFoundError
from evastudio.learning.familiarity import Familiarity
from evastudio.learning.learner import Indices
from evastudio.pilots.guard import GuardedPilot
from evastudio.pilots.memories import within
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.switchboard import Switchboard
from evastudio.world.cast import of_lead
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Why:
    """What one decision of the lead came from. The nearest demonstration comes first."""

    policy: str
    """Name of the policy that decided."""
    pairs: Indices
    """Of those that its learner keeps, shape (k,)."""
    moments: Indices | None
    """Take and step of each, shape (k, 2); None where the policy does not know."""
    distances: Array
    """Shape (k,), standardised."""
    weights: Array
    """How much each counted, shape (k,), summing to 1."""
    actions: Array | None
    """What was done then, as it would be done here: in the world's frame, shape (k, m)."""
    agreement: float | None
    """See `Reasons.agreement`."""
    familiarity: float | None
    """See `Familiarity`; None where the policy kept no pairs, or does not know their takes."""
    store: str | None = None
    """Identity of the session store that has the takes; None where the policy does not know."""


class Reasoner:
    """Gives the reasons of a pilot that decides by policies."""

    def __init__(self, pilot: Pilot) -> None:
        """Looks at how far apart the demonstrations of its policies are, which takes a while."""
        self._pilot = pilot
        self._familiar = {id(one): _familiarity(one) for one in _policies(pilot)}

    def why(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> Why | None:
        """The reasons for what the pilot decides for the lead in the first world of `snapshot`.

        `memory` is what the pilot had before it. None where no policy decides.
        """
        decides = _deciding(self._pilot, scene, snapshot, memory)
        if decides is None:
            return None
        policy = decides.policy
        view = scene.perceptions[policy.perception]
        percept = view.perceive(snapshot)
        reasons = policy.explain(of_lead(snapshot, percept.states)[:1])
        pairs, distances = reasons.pairs[0], reasons.distances[0]
        actions = policy.learner.shown(pairs)
        if actions is not None:
            frame = of_lead(snapshot, percept.frame)[:1]
            actions = view.to_world(np.repeat(frame, len(pairs), axis=0), actions)
        familiar = self._familiar[id(decides)]
        return Why(
            decides.name,
            pairs,
            None if policy.moments is None else policy.moments[pairs],
            distances,
            reasons.weights[0],
            actions,
            None if reasons.agreement is None else float(reasons.agreement[0]),
            float(familiar.of(distances[0])) if familiar and len(distances) else None,
            policy.extra.get("store"),
        )

    @property
    def pilots(self) -> tuple[PolicyPilot, ...]:
        """Of every policy that it can decide by."""
        return tuple(_policies(self._pilot))

    def silence(self, why: Why | None) -> str | None:
        """Why the decision that `why` is of cannot be told reasons for; None where it can."""
        if why is None:
            return (
                f"“{self._pilot.name}” decides by a program here: it was not shown what to do, so "
                "there are no moments that it decides from."
            )
        if len(why.pairs) == 0 or why.moments is None or why.actions is None:
            return (
                f"“{why.policy}” was saved in a compact form, without the moments it learned from: "
                "it cannot tell why, nor how like your takes this is. A policy that you fit from "
                "your own takes can."
            )
        return None

    def holder(self, take: int, step: int) -> tuple[PolicyPilot, Indices]:
        """The policy that keeps that demonstrated moment, and as which of its pairs.

        Raises NotFoundError.
        """
        for pilot in _policies(self._pilot):
            moments = pilot.policy.moments
            if moments is not None:
                pairs = np.flatnonzero((moments[:, 1] == step) & (moments[:, 0] == take))
                if len(pairs):
                    return pilot, pairs
        raise NotFoundError(
            f"{self._pilot.name!r} has not learned from moment {step} of take {take}, or has "
            "forgotten it already."
        )


def _policies(pilot: Pilot) -> Iterator[PolicyPilot]:
    if isinstance(pilot, PolicyPilot):
        yield pilot
    elif isinstance(pilot, GuardedPilot):
        yield from _policies(pilot.pilot)
    elif isinstance(pilot, Switchboard):
        for one in pilot.pilots:
            yield from _policies(one)


def _familiarity(pilot: PolicyPilot) -> Familiarity | None:
    states, moments = getattr(pilot.policy.learner, "states_", None), pilot.policy.moments
    if states is None or moments is None or len(states) < 2:
        return None
    return Familiarity(states, moments[:, 0])


def _deciding(pilot: Pilot, scene: Scene, snapshot: Snapshot, memory: Memory) -> PolicyPilot | None:
    """The policy that decides for the lead now."""
    if isinstance(pilot, GuardedPilot):
        return _deciding(pilot.pilot, scene, snapshot, memory)
    if isinstance(pilot, Switchboard):
        acting, _ = pilot.acting(scene, snapshot, memory)
        number = int(of_lead(snapshot, acting)[0])
        return _deciding(pilot.pilots[number], scene, snapshot, within(f"{number}.", memory))
    return pilot if isinstance(pilot, PolicyPilot) else None
