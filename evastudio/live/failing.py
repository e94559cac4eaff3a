"""Where does a policy fail? New worlds are flown without a screen until enough have failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from evastudio.evaluation.blaming import blaming
from evastudio.evaluation.evaluate import MAX_STEPS, Flown, fly
from evastudio.evaluation.flight import Flight, Logbook
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.compiled import ensure_compiled
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot, scene_of
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import Workspace
from evastudio.world.cast import of_lead
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds

WORLDS = 64
MOST = 8
"""Failures that are enough."""
TOGETHER = 16
"""Worlds flown at a time."""
LOOKED_AT = 16
"""Worlds in which the strangest moment is looked for, where nothing else is found."""
NEAR, STRANGE = "near", "strange"


@dataclass(frozen=True)
class Failure:
    """When a world went wrong, or would have most likely."""

    seed: int
    outcome: str
    """Of the scene's outcomes; in a world that went well 'near' for a close call, or 'strange' for
    the moment that was least like what the policy was shown."""
    seconds: float
    """Since the world began."""


def find_failures(
    workspace: Workspace,
    policy: str,
    *,
    scene: str | None = None,
    options: Mapping[str, float] | None = None,
    worlds: int = WORLDS,
    seed: int = 0,
    most: int = MOST,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Fly `policy` through up to `worlds` new worlds that follow from `seed`, until `most` failed.

    `failures` in what is told are those, the first world first; where none failed, the closest
    calls, the closest first, and where there were none, the moments that were least like what was
    shown. `failed` counts the failures among the `worlds` that were flown.
    """
    progress(0.0, "Getting ready")
    ensure_compiled()
    place = make_scene(workspace, scene or scene_of(workspace, [policy]), options)
    pilot = load_pilot(workspace, policy, place)
    seeds = world_seeds(seed, worlds)
    found: list[Failure] = []
    close: list[tuple[float, int]] = []
    flown = 0
    while flown < worlds and len(found) < most:
        part = seeds[flown : flown + TOGETHER]
        result = fly(place, pilot, part, MAX_STEPS, policy)
        flown += len(part)
        found += _failed(place, result)
        close += _close(place, result)
        progress(flown / worlds, f"{len(found)} failures in {flown} worlds")
    failures = found[:most]
    if not found:
        failures = [_closest(place, pilot, policy, world) for _, world in sorted(close)[:most]]
        failures = failures or _strangest(place, pilot, policy, seeds[:LOOKED_AT])[:most]
    progress(1.0, "Looked")
    return {
        "policy": policy,
        "scene": place.name,
        "options": dict(place.values),
        "seed": seed,
        "worlds": flown,
        "failed": len(found),
        "failures": [asdict(one) for one in failures],
    }


def _failed(scene: Scene, flown: Flown) -> list[Failure]:
    """Of the worlds of `flown` those that ended badly."""
    rollout = flown.rollout
    return [
        Failure(seed, scene.outcomes[code], steps * scene.dt_s)
        for seed, code, steps in zip(
            rollout.seeds, rollout.outcomes.tolist(), rollout.steps.tolist(), strict=True
        )
        if code and scene.outcomes[code] not in scene.successes
    ]


def _close(scene: Scene, flown: Flown) -> list[tuple[float, int]]:
    """How near each came to what it must not touch, and its seed, where that was a close call."""
    closest = flown.figures["closest_m"].tolist()
    return [
        (metres, seed)
        for metres, seed in zip(closest, flown.rollout.seeds, strict=True)
        if metres < scene.near_m
    ]


def _closest(scene: Scene, pilot: Pilot, name: str, seed: int) -> Failure:
    """When a world came to its closest call."""
    (flight,) = _flights(scene, pilot, name, [seed])
    return Failure(seed, NEAR, int(np.argmin(flight.clearances)) * scene.dt_s)


def _strangest(scene: Scene, pilot: Pilot, name: str, seeds: Sequence[int]) -> list[Failure]:
    """When each world was least like what `pilot` was shown, the strangest first.

    Empty where it keeps nothing of what it was shown.
    """
    if not isinstance(pilot, PolicyPilot):
        return []
    view, found = scene.perceptions[pilot.policy.perception], []
    for seed, flight in zip(seeds, _flights(scene, pilot, name, seeds), strict=True):
        states = of_lead(flight.moments, view.perceive(flight.moments).states)
        distances = pilot.policy.explain(states).distances
        if distances.shape[1] == 0:
            return []
        step = int(np.argmax(distances[:, 0]))
        found.append((-distances[step, 0], Failure(seed, STRANGE, step * scene.dt_s)))
    return [failure for _, failure in sorted(found, key=lambda one: one[0])]


def _flights(scene: Scene, pilot: Pilot, name: str, seeds: Sequence[int]) -> list[Flight]:
    log = Logbook(scene)
    with blaming(scene, name):
        roll_out(scene, pilot, seeds, max_steps=MAX_STEPS, watcher=log)
        return log.flights()
