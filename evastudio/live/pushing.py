"""Pushes: keys held for a little while on a character's behalf, to bring it where nobody took it.

The paper (section 5): a demonstrator's choices may leave regions of the state space unvisited,
which can be solved by forcing the character into them now and then.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from evastudio.learning.familiarity import Familiarity
from evastudio.learning.holdout import Mask
from evastudio.learning.learner import Indices
from evastudio.learning.neighbors import NeighborIndex
from evastudio.learning.scaling import Scaling
from evastudio.live.inputs import HeldKeys
from evastudio.world.cast import for_all, of_lead
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import Snapshot, stack
from evastudio.world.spaces import Array

LASTS_S = (0.5, 1.5)
"""How long a push lasts."""
FREE_S = 1.0
"""So long after it nothing may go wrong if nobody steers: one can still get out of it."""
EVERY_S = (5.0, 10.0)
"""From one push of a demonstration to the next."""
TRIED = 8
"""Pushes that are tried before one is chosen."""


@dataclass(frozen=True)
class Push:
    """What is held, and for how many decision steps."""

    keys: tuple[str, ...]
    steps: int

    def actions(self, scene: Scene) -> Array:
        """What that comes to, step by step, (steps, action size)."""
        held = HeldKeys(scene.controls, scene.action, scene.dt_s)
        held.hold(self.keys, 0.0)
        edges = [step * scene.dt_s for step in range(self.steps + 1)]
        return np.concatenate([held.read(*edge) for edge in pairwise(edges)])

    def applied(self, scene: Scene, moments: Snapshot) -> Snapshot:
        """`moments` (worlds) after it; the others rest where there are any."""
        for action in self.actions(scene):
            moments = _stepped(scene, moments, action)
        return moments


class Shown:
    """What was demonstrated, as one perception shows it."""

    def __init__(self, view: Perception, states: Array, takes: Indices) -> None:
        """`states` (pairs, n) under `view`, `takes` (pairs,). At least two pairs."""
        self._view = view
        self._scaling = Scaling.of(states)
        scaled = self._scaling.apply(states)
        self._index = NeighborIndex(scaled)
        self._familiarity = Familiarity(scaled, takes)

    def distances(self, moments: Snapshot) -> Array:
        """How far the lead of each of `moments` is from what was shown, standardised, (worlds,)."""
        states = of_lead(moments, self._view.perceive(moments).states)
        return self._index.nearest(self._scaling.apply(states), 1)[0][:, 0]

    def familiarity(self, distances: Array) -> Array:
        """See `Familiarity.of`."""
        return self._familiarity.of(distances)


class Pushes:
    """When a character that is demonstrated is pushed off its way, and how."""

    def __init__(self, scene: Scene, rng: np.random.Generator, shown: Shown | None) -> None:
        """`shown` is what was demonstrated before; None where that is nothing yet."""
        self._scene = scene
        self._rng = rng
        self._shown = shown
        self._left: list[Array] = []
        self._wait = self._until_next()

    def next(self, moment: Snapshot) -> Array | None:
        """The forced action of the next decision, (1, action size); None where it is free."""
        if not self._left:
            self._wait -= 1
            if self._wait > 0:
                return None
            self._wait = self._until_next()
            chosen = self._choose(moment)
            if chosen is None:
                return None
            self._left = list(chosen.actions(self._scene))
        return self._left.pop(0)[None, :]

    def _until_next(self) -> int:
        return round(self._rng.uniform(*EVERY_S) / self._scene.dt_s)

    def _choose(self, moment: Snapshot) -> Push | None:
        """Of a few pushes the one that leads farthest from what was shown; None where all would
        end badly."""
        scene = self._scene
        steps = drawn_steps(scene, self._rng)
        tried = [Push(drawn_keys(scene, self._rng), steps) for _ in range(TRIED)]
        plans = np.stack([push.actions(scene) for push in tried])
        moments = stack([moment] * TRIED)
        for step in range(steps):
            moments = scene.step(moments, for_all(scene, moments, plans[:, step]))
        far = self._rng.random(TRIED) if self._shown is None else self._shown.distances(moments)
        far = np.where(can_go_on(scene, moments), far, -np.inf)
        best = int(far.argmax())
        return tried[best] if np.isfinite(far[best]) else None


def drawn_keys(scene: Scene, rng: np.random.Generator) -> tuple[str, ...]:
    """Keys of one control or more, each to one of its sides."""
    sides = [[side[0] for side in (one.negative, one.positive) if side] for one in scene.controls]
    sides = [side for side in sides if side]
    if not sides:
        return ()
    pressed = rng.random(len(sides)) < 0.6
    pressed[rng.integers(len(sides))] = True
    return tuple(
        side[rng.integers(len(side))]
        for side, now in zip(sides, pressed.tolist(), strict=True)
        if now
    )


def drawn_steps(scene: Scene, rng: np.random.Generator) -> int:
    """How long a push lasts, in decision steps."""
    return max(1, round(float(rng.uniform(*LASTS_S)) / scene.dt_s))


def can_go_on(scene: Scene, moments: Snapshot) -> Mask:
    """In which of `moments` nothing is lost yet, (worlds,): none ends badly for a while."""
    good = np.array([name in scene.successes for name in scene.outcomes])
    going: Mask = scene.outcome(moments) == 0
    (rest,) = Push((), 1).actions(scene)
    for _ in range(max(1, round(FREE_S / scene.dt_s))):
        moments = _stepped(scene, moments, rest)
        outcome = scene.outcome(moments)
        going &= (outcome == 0) | good[outcome]
    return going


def _stepped(scene: Scene, moments: Snapshot, action: Array) -> Snapshot:
    """`moments` a step later, in all of which the lead does `action` (m,)."""
    actions = np.broadcast_to(action, (moments.worlds, len(action)))
    return scene.step(moments, for_all(scene, moments, actions))
