"""Flights through asteroid fields by a policy, several times as fast as a rollout.

A few worlds at a time go in step, so few that what is around each ship stays in the processor's
cache. Compiled code does what `scenes/asteroids.py` does, and NumPy what both leave to it, so that
every moment is bit for bit that of a rollout: no result tells which way was taken.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from typing import TypeGuard

import numpy as np

from evastudio.evaluation.flight import Flight, flight_of
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import shipped
from evastudio.world.compiled import is_compiled
from evastudio.world.rocks import MOST, ROWS, SLAB
from evastudio.world.rollout import Pilot, Rollout
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array, Box

TOGETHER = 64
"""Worlds in step: more fall out of the cache, fewer do not pay for the calls."""
VIEW = "canonical"


def goes_in_step(pilot: Pilot, scene: Scene) -> TypeGuard[PolicyPilot]:
    """Whether `pilot` in `scene` is what this module does: a policy in the shipped asteroid field.

    It perceives through `canonical` and draws no random numbers; the kernels are compiled.
    """
    if type(pilot) is not PolicyPilot or not is_compiled():
        return False
    policy = pilot.policy
    module = sys.modules[type(scene).__module__]
    return (
        getattr(module, "__source__", None) == _text()
        and type(scene) is module.SCENE
        and type(scene.perceptions.get(VIEW)) is module.Canonical
        and policy.perception == VIEW
        and not policy.learner.draws
    )


@cache
def _text() -> str:
    """The scene file whose arithmetic the compiled code has, as this package ships it."""
    return (shipped() / "scenes" / "asteroids.py").read_text(encoding="utf-8")


def fly_in_step(
    scene: Scene, pilot: PolicyPilot, seeds: Sequence[int], *, max_steps: int
) -> tuple[Rollout, list[Flight]]:
    """As `roll_out` with a `Logbook`; see `goes_in_step` for what may be given."""
    pilot.check(scene)
    groups = -(-len(seeds) // TOGETHER)
    size = -(-len(seeds) // groups)
    parts = [
        _together(scene, pilot, seeds[start : start + size], max_steps)
        for start in range(0, len(seeds), size)
    ]
    rollouts = [rollout for rollout, _ in parts]
    whole = Rollout(
        tuple(seeds),
        np.concatenate([rollout.outcomes for rollout in rollouts]),
        np.concatenate([rollout.steps for rollout in rollouts]),
        np.concatenate([rollout.turn for rollout in rollouts]),
    )
    return whole, [flight for _, flights in parts for flight in flights]


def _together(
    scene: Scene, pilot: PolicyPilot, seeds: Sequence[int], max_steps: int
) -> tuple[Rollout, list[Flight]]:
    from evastudio.world.kernels import field  # numba loads slowly

    snapshot = scene.worlds(seeds)
    fixed = snapshot.fixed
    place = fixed["rocks"], fixed["cells"], fixed["half"]
    numbers = _numbers(scene)
    state = scene.perceptions[VIEW].state
    decide = pilot.policy.learner.decide
    worlds = len(seeds)
    longest = min(max_steps, int(np.ceil(numbers[field.LIMIT] / scene.dt_s)) + 1)
    now = {name: np.array(snapshot[name]) for name in ("position", "heading", "turn")}
    position, heading = now["position"], now["heading"]
    log: dict[str, AnyArray] = {
        name: np.empty((worlds, longest, array.shape[1])) for name, array in now.items()
    }
    actions = np.empty((worlds, longest, 2))
    logged = log["position"], log["heading"], log["turn"], actions, now["turn"]
    change = np.zeros(worlds)
    steps, outcomes = np.zeros(worlds, np.int64), np.zeros(worlds, np.int64)
    cosines, sines = np.cos(heading), np.sin(heading)
    threats = np.empty((worlds, MOST, 3))
    aside, weights = np.empty((worlds, MOST)), np.empty((worlds, MOST))
    states, frames = np.empty((worlds, state.size)), np.empty((worlds, 2, 2))
    low, high = state.low, state.high
    alive, count = np.arange(worlds), worlds
    for moment in range(longest):
        field.look(
            *place, ROWS, numbers, alive, count, position, cosines, sines, threats, aside, weights
        )
        np.exp(weights[:count], out=weights[:count])
        field.perceive(
            numbers, place[2], alive, count, position, heading, threats, aside, weights, low, high,
            states, frames,
        )  # fmt: skip
        chosen = decide(states[:count])
        field.turn(
            numbers, alive, count, moment, chosen, frames, heading, position, change, *logged
        )
        np.cos(heading, out=cosines)
        np.sin(heading, out=sines)
        steps[alive[:count]] += 1
        count = field.move(
            *place, ROWS, numbers, alive, count, moment + 1, position, cosines, sines, outcomes
        )
        if count == 0:
            break
    flights = []
    for world, taken in enumerate(steps):
        moving = {name: array[world, :taken] for name, array in log.items()}
        moving["steps"] = np.arange(taken)
        own = {name: array[world] for name, array in fixed.items()}
        flights.append(flight_of(scene, own, moving, actions[world, :taken]))
    return Rollout(tuple(seeds), outcomes, steps, change / np.maximum(steps - 1, 1)), flights


def _numbers(scene: Scene) -> Array:
    """The numbers of the scene that its file holds, as the compiled code reads them."""
    from evastudio.world.kernels import field

    module = sys.modules[type(scene).__module__]
    assert isinstance(scene.action, Box)
    numbers = np.empty(field.NUMBERS_OF)
    numbers[:] = (
        module.SPEED * scene.dt_s, module.TURN, module.HEADING, module.ROCK_RADIUS, module.REACH,
        module.SIGHT, module.MARGIN, scene.values["half_width"], module.LENGTH, scene.dt_s,
        module.TIME_LIMIT_S, module.Canonical.fade_ahead, module.Canonical.fade_aside, SLAB,
    )  # fmt: skip
    return numbers
