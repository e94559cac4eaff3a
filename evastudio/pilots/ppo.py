"""Reinforcement learning by proximal policy optimisation: practice and reward, no demonstration.

J. Schulman and others, "Proximal policy optimization algorithms", 2017, by Stable-Baselines3, which
is the extra `evastudio[rl]`. What comes out is a policy like any other: it plays without the extra.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.mlp import MLPPolicy
from evastudio.learning.policy import Policy
from evastudio.world.scene import Perception, Scene
from evastudio.world.spaces import Array, Box


@dataclass(frozen=True)
class Lesson:
    """Where practice stood after what was seen had been learned from."""

    decisions: int
    """Decisions practised so far, in all worlds."""
    cpu_s: float
    """Processor time so far, without what `watch` took."""
    network: MLPPolicy
    """The policy so far, without the chance that it practises by."""


@dataclass(frozen=True)
class PPO:
    """How to practise."""

    decisions: int = 1_000_000
    """Decisions to practise; rounded up to whole lessons."""
    worlds: int = 128
    """Worlds practised in at a time."""
    between: int = 32
    """Decisions in each world between two lessons."""
    batch: int = 1024
    """Decisions in one step of a lesson."""
    epochs: int = 5
    """How often a lesson goes over what was seen."""
    hidden: int = 32
    """Hidden units of the policy, one layer of tanh; the critic has two layers of 64."""
    rate: float = 5e-4
    """Of learning."""
    discount: float = 0.99
    """What a reward one decision later is worth."""
    calm: float = 0.0
    """What the squared action, as a share of half its range, costs at each decision. Zero is the
    reward as it is in the scene's Gymnasium environment."""
    seed: int = 0
    """Decides the worlds, the first weights and the chances taken."""

    def __post_init__(self) -> None:
        for name in ("decisions", "worlds", "between", "batch", "epochs", "hidden"):
            if not isinstance(getattr(self, name), int) or getattr(self, name) < 1:
                raise InvalidInputError(
                    f"{name} is {getattr(self, name)!r}; it must be a whole number from 1 on."
                )
        if not 0.0 < self.discount <= 1.0 or not 0.0 < self.rate < 1.0 or not self.calm >= 0.0:
            raise InvalidInputError(
                f"The discount is {self.discount}, the rate {self.rate} and calm {self.calm}; a "
                "discount and a rate lie between 0 and 1, and calm is not negative."
            )

    def learn(
        self,
        scene: Scene,
        perception: str | Perception | None = None,
        *,
        watch: Callable[[Lesson], None] | None = None,
        cpu: Callable[[], float] = time.process_time,
    ) -> Policy:
        """The policy after all `decisions`. `watch` hears each lesson; what it raises ends them.

        Raises InvalidInputError where actions are symbols, ConflictError where the extra is not
        installed.
        """
        view = scene.perception(perception)
        action = scene.chosen(view)
        if not isinstance(action, Box):
            raise InvalidInputError(
                f"PPO is offered for actions that are numbers, and those of scene {scene.name!r} "
                f"under {view.name!r} are symbols."
            )
        try:
            from evastudio.pilots.stable_baselines import lessons
        except ImportError as error:
            raise ConflictError(
                f"Learning by reward needs the package {error.name!r}, which is not installed. "
                "Install evastudio[rl]; docs/baselines.md says how to get a small PyTorch with it."
            ) from None
        spent, began, network, decisions = 0.0, cpu(), None, 0
        for decisions, weights in lessons(self, scene, view):
            network = as_network(self, weights, action)
            spent += cpu() - began
            if watch is not None:
                watch(Lesson(decisions, spent, network))
            began = cpu()
        assert network is not None
        return Policy(
            learner=network,
            scene=scene.identity(),
            perception=view.name,
            state=view.state,
            action=action,
            pairs=0,
            fingerprint="",
            extra={"ppo": {**asdict(self), "decisions": decisions}},
        )


@dataclass(frozen=True)
class Weights:
    """Of a policy as it is practised: standardised states in, shares of half the range out."""

    inner: Array
    """(states, hidden)"""
    inner_bias: Array
    outer: Array
    """(hidden, actions)"""
    outer_bias: Array
    offset: Array
    """(states,)"""
    scale: Array


def as_network(settings: PPO, weights: Weights, action: Box) -> MLPPolicy:
    """The same policy as a learner that was fitted to nothing, in units of the `action`."""
    half, middle = (action.high - action.low) / 2, (action.high + action.low) / 2
    made = MLPPolicy(hidden=settings.hidden, seed=settings.seed)
    made.inner_, made.inner_bias_ = weights.inner, weights.inner_bias
    made.outer_, made.outer_bias_ = weights.outer * half, weights.outer_bias * half + middle
    made.offset_, made.scale_ = weights.offset, weights.scale
    made.n_features_in_, made.flat_ = len(weights.offset), False
    return made.prepare()
