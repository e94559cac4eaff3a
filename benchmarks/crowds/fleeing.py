"""How a crowd flees from the boulder that learned it from 200 pairs.

What `crowd.py` measures; nothing here is run by itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.crowds.walking import CROWD, SCENE
from evastudio.demonstrations.pairs import Pairs, join_pairs, perceive_take
from evastudio.evaluation.flight import Logbook
from evastudio.learning.fitting import fit_policy
from evastudio.pilots.lead import LeadPilot
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import Pilot, roll_out

PAIRS = 200
NEAR = 20.0
"""Metres from the boulder within which everybody has to flee."""
AT_ONCE_S = 1.0
FAST = 2.0
"""Metres a second from which on one runs."""
AWAY = np.radians(45.0)
"""Who runs within this of straight away from the boulder flees."""
WATCHED_S = 5.0
CALM_S = 10.0
LEARNERS: dict[str, tuple[str, dict[str, Any]]] = {
    "local-linear, as shipped": ("local-linear", {"k": 6, "ridge": 0.001}),
    "k-NN": ("knn", {}),
    "SVR": ("svr", {}),
}


@dataclass(frozen=True)
class Fled:
    """How one crowd fled."""

    near: int
    """People nearer than `NEAR` at the impact."""
    hit: int
    """Those of them whom it knocked over; they are timed from when they are up."""
    fled: float
    """Share of them that flee `AT_ONCE_S` after they can, and go on to."""
    first_deg: float
    """Mean angle between heading and straight away, `AT_ONCE_S` after they can flee."""
    later_deg: float
    """That from then on until `WATCHED_S` after."""


def shown(seed: int) -> Pairs:
    """The first `PAIRS` pairs of the scripted lead who runs, among people who stand still."""
    scene, parts, take = CROWD(), [], 0
    while sum(map(len, parts)) < PAIRS:
        log = Logbook(scene)
        pilot = LeadPilot(find_pilot("scripted:startled"))
        roll_out(scene, pilot, [seed * 1000 + take], watcher=log)
        (flight,) = log.flights()
        view = scene.perceptions["boulder"]
        parts.append(perceive_take(view, flight.moments, flight.actions, take))
        take += 1
    pairs = join_pairs(parts)
    return pairs.keep(np.arange(len(pairs)) < PAIRS)


def flee(walker: Pilot, learner: str, settings: dict[str, Any], seed: int, people: int) -> Fled:
    """`walker` walks everybody until the impact, then a policy from demonstration `seed` runs."""
    scene = CROWD(people=people, side=40)
    policy = fit_policy(shown(seed), scene, "boulder", learner, settings)
    runner = PolicyPilot(policy)
    snapshot, memory = scene.worlds([seed]), walker.begin(scene, [seed])
    for step in range(round((CALM_S + SCENE.FALL_S) / scene.dt_s) + 2):
        actions, memory = walker.act(scene, snapshot, memory)
        if step == round(CALM_S / scene.dt_s):
            actions[:, 0, 2] = 1.0
            actions[:, 0, 3:5] = snapshot["position"][:, 0] + (4.0, 3.0)
        snapshot = scene.step(snapshot, actions)
        if snapshot["boulder"][0, 2] >= SCENE.FALL_S:
            break
    apart = snapshot["position"][0] - snapshot["boulder"][0, :2]
    near = np.hypot(*apart.T) < NEAR
    hit = snapshot["hit"][0] > 0
    free_s = np.where(hit, SCENE.DOWN_S, 0.0)
    fled, first, later = near.copy(), np.zeros(people), []
    while (since := snapshot["boulder"][0, 2] - SCENE.FALL_S) < WATCHED_S + SCENE.DOWN_S:
        actions, _ = runner.act(scene, snapshot, {})
        snapshot = scene.step(snapshot, actions)
        since = float(snapshot["boulder"][0, 2] - SCENE.FALL_S)
        apart = snapshot["position"][0] - snapshot["boulder"][0, :2]
        off = snapshot["heading"][0] - np.arctan2(apart[:, 1], apart[:, 0])
        off = np.abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi)
        runs = (snapshot["speed"][0] >= FAST) & (off <= AWAY)
        due = since >= free_s + AT_ONCE_S - 1e-9
        fled &= runs | ~due
        first = np.where(np.isclose(since, free_s + AT_ONCE_S), np.degrees(off), first)
        later.append(np.where(due & (since < free_s + WATCHED_S), np.degrees(off), np.nan)[near])
    return Fled(
        int(near.sum()),
        int((near & hit).sum()),
        float(fled[near].mean()),
        float(first[near].mean()),
        float(np.nanmean(later)),
    )
