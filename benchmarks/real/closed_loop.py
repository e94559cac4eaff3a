"""Push-T played: a policy moves the agent through gym-pusht until the block lies where it should.

The score of an episode is its largest reward (the share of the goal that the block covers, 1 from
95 % on), of a policy the mean over episodes; 300 steps of 0.1 s, starts drawn by the environment.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from benchmarks.real.push import Perception
from evastudio.demonstrations.pairs import Pairs
from evastudio.world.spaces import Array

STEPS = 300
FIRST_SEED = 200_000
"""Of the episodes reported; chunks were tried out on the 30 seeds from 100,000 on."""


class Answers(Protocol):
    """What is played: a fitted learner."""

    def predict(self, states: Array, /) -> Any:
        """Steps (rows, 2 or 2 * chunk) in the perception's own frame for states (rows, n)."""


@dataclass(frozen=True)
class Played:
    """Episodes of one policy."""

    scores: Array
    """Largest reward of each episode, shape (episodes,)."""

    @property
    def solved(self) -> int:
        """Episodes that covered 95 % of the goal."""
        return int((self.scores >= 1.0).sum())


def chunks(
    pairs: Pairs, perception: Perception, worlds: Array, targets: Array, every: int
) -> Pairs:
    """Push-T pairs whose actions are the targets of `every` steps, (pairs, 2 * every).

    All are relative to the agent at the first of them; a demonstration's last target is held.
    `worlds` (pairs, 5) and `targets` (pairs, 2) are in the world's frame.
    """
    percept = perception.perceive(worlds)
    last = np.searchsorted(pairs.takes, pairs.takes, side="right") - 1
    rows = np.arange(len(pairs))
    ahead = [targets[np.minimum(rows + step, last)] for step in range(every)]
    actions = [perception.to_own(percept, one) for one in ahead]
    return replace(pairs, actions=np.concatenate(actions, axis=1))


def environments(count: int) -> list[Any]:
    """Ready environments with the seeds from FIRST_SEED on."""
    try:
        import gym_pusht.envs.pusht as pusht
    except ImportError:
        raise SystemExit(
            "Push-T is played through gym-pusht, which is not installed: "
            "pip install 'evastudio[bench]'."
        ) from None
    return [pusht.PushTEnv(obs_type="state") for _ in range(count)]


def play(learner: Answers, perception: Perception, episodes: int, every: int = 1) -> Played:
    """Plays `episodes` at once, one decision for all of them each step.

    A learner that answers with the targets of several steps (`every` of them) is asked once in
    so many steps; they are relative to where the agent was when it was asked.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        worlds = environments(episodes)
        seen = np.array([world.reset(seed=FIRST_SEED + at)[0] for at, world in enumerate(worlds)])
        best = np.zeros(episodes)
        playing = np.arange(episodes)
        plan: Array = np.empty((episodes, every, 2))
        for step in range(STEPS):
            if step % every == 0:
                percept = perception.perceive(seen[playing])
                own = np.asarray(learner.predict(percept.states)).reshape(len(playing), every, 2)
                for ahead in range(every):
                    plan[playing, ahead] = perception.to_world(percept, own[:, ahead])
            for at in playing:
                world_seen, reward, done, _, _ = worlds[at].step(plan[at, step % every])
                seen[at] = world_seen
                best[at] = max(best[at], float(reward))
                if done:
                    best[at] = 1.0
            playing = playing[best[playing] < 1.0]
            if len(playing) == 0:
                break
    return Played(best)
