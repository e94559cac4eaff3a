"""A policy as a pilot: perceive, decide, turn the action back to the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evastudio.errors import ConflictError
from evastudio.learning.policy import Policy
from evastudio.pilots.chance import uniforms
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

_LUCK = 0
"""The one stream of random numbers that a policy draws from."""


class PolicyPilot(Pilot):
    """Flies as `policy` decides. It remembers nothing: the paper's policies are reactive.

    One that decides by chance draws from the world's seed and step, which are then its memory.
    """

    reactive = True

    def __init__(self, policy: Policy, name: str = "policy") -> None:
        self.policy = policy
        self.name = name

    def check(self, scene: Scene) -> None:
        """Raise ConflictError where the policy was not made for `scene` as it is now.

        Options may differ: a policy from a sparse field can be tried in a dense one.
        """
        policy = self.policy
        if (policy.scene_name, policy.scene_version) != (scene.name, scene.version):
            raise ConflictError(
                f"The policy was made for scene {policy.scene_name!r} version "
                f"{policy.scene_version}, and this is scene {scene.name!r} version "
                f"{scene.version}. Fit a policy from takes of this scene."
            )
        if policy.perception not in scene.perceptions:
            raise ConflictError(
                f"The policy perceives through {policy.perception!r}, which scene {scene.name!r} "
                f"does not offer (it has {', '.join(scene.perceptions)}). Fit it again."
            )
        view = scene.perceptions[policy.perception]
        given = scene.chosen(view)
        if view.state.names != policy.state.names or given.names != policy.action.names:
            raise ConflictError(
                f"The policy expects the state {', '.join(policy.state.names)} and gives "
                f"{', '.join(policy.action.names)}; perception {view.name!r} of scene "
                f"{scene.name!r} has changed since. Fit it again."
            )

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        if not self.policy.learner.draws:
            return {}
        return {
            "seed": np.array(seeds, dtype=np.uint64),
            "step": np.zeros(len(seeds), dtype=np.int64),
        }

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        self.check(scene)
        view = scene.perceptions[self.policy.perception]
        percept = view.perceive(snapshot)
        everybody = percept.states.shape[:-1]
        states = percept.states.reshape(-1, percept.states.shape[-1])
        if self.policy.learner.draws:
            count = len(states) // snapshot.worlds
            draws = uniforms(memory["seed"], memory["step"], _LUCK, count).reshape(-1)
            actions = self.policy.learner.decide(states, draws)
            memory = {**memory, "step": memory["step"] + 1}
        else:
            actions = self.policy.learner.decide(states)
        return view.to_world(percept.frame, actions.reshape(*everybody, -1)), memory
