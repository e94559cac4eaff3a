"""Pedestrians in corridors: pairs of a walker's view and its change of velocity, and rollouts.

A walker sees its velocity, the way to its goal and the three nearest people ahead, in a frame
whose x axis points to the goal. The goal is where the recording last saw it, as in the published
figures; it is given to all that use it, and constant velocity does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.real.push import rotations
from benchmarks.real.recordings import Recording
from evastudio.demonstrations.pairs import Pairs, join_pairs
from evastudio.world.spaces import Array

AHEAD = 12
"""Steps of a rollout, 4.5 to 4.8 s."""
SEEN = 3
"""People that a walker sees."""
REACH_M = 2.0
"""Distance over which the weight of a person seen falls to 1/e."""
ARRIVED_M = 0.5
"""So near its goal a walker goes on as it was."""
EXPERIMENTS = {
    "basigo2013_bidir_400_b_03": (12080, 480),
    "hermes2009_uo-050-180-180": (1626, 61),
    "hermes2009_uo-060-180-180": (1744, 66),
    "hermes2009_uo-070-180-180": (3050, 111),
    "hermes2009_uo-100-180-180": (3618, 121),
    "hermes2009_uo-145-180-180": (6858, 175),
    "hermes2009_uo-180-180-070": (12559, 148),
    "hermes2009_uo-180-180-095": (12085, 159),
    "hermes2009_uo-180-180-120": (9164, 170),
    "hermes2009_uo-180-180-180": (8593, 220),
    "wuppertal2018_bottleneck_040_c_56": (6344, 75),
}
"""Rows and people of each file."""


@dataclass(frozen=True)
class Experiment:
    """Where everybody was at each step."""

    name: str
    positions: Array
    """Metres, shape (steps, people, 2); NaN where a person is not there."""
    goals: Array
    """The last place of each, shape (people, 2)."""
    dt_s: float


def read_experiment(path: Path) -> Experiment:
    """One file: a line on source and rate, then frame, person, x and y in metres."""
    try:
        first = path.read_text(encoding="utf-8").partition("\n")[0]
        rows = np.loadtxt(path)
        dt_s = float(first.partition("(")[2].partition("s)")[0])
    except (OSError, ValueError) as error:
        raise SystemExit(f"{path} cannot be read as people walking: {error}.") from None
    frames, step = np.unique(rows[:, 0], return_inverse=True)
    if len(frames) > 1:
        step = np.rint((rows[:, 0] - frames[0]) / np.diff(frames).min()).astype(np.int64)
    people, person = np.unique(rows[:, 1], return_inverse=True)
    positions = np.full((int(step.max()) + 1, len(people), 2), np.nan)
    positions[step, person] = rows[:, 2:4]
    last = np.zeros(len(people), dtype=np.int64)
    np.maximum.at(last, person, step)
    return Experiment(path.stem, positions, positions[last, np.arange(len(people))], dt_s)


def read_walkers(folder: Path) -> tuple[Experiment, ...]:
    """The eleven experiments, checked against the rows and people they should have."""
    experiments = []
    for name, expected in EXPERIMENTS.items():
        experiment = read_experiment(folder / "juelich" / f"{name}.txt")
        there = ~np.isnan(experiment.positions[:, :, 0])
        found = (int(there.sum()), there.shape[1])
        if found != expected:
            raise SystemExit(f"{name} has {found} rows and people; {expected} were expected.")
        experiments.append(experiment)
    return tuple(experiments)


def perceive(places: Array, velocities: Array, goals: Array) -> tuple[Array, Array]:
    """States (people, 3 + 4 * SEEN) of people at one moment, and turns (people, 2, 2) to them.

    places in m, velocities in m/s and goals in m are (people, 2). A state is the own velocity,
    the distance to the goal (at most 5 m), and of each person seen the direction and the relative
    velocity, both fading with distance; zeros where there is nobody.
    """
    way = goals - places
    turns = rotations(-np.arctan2(way[:, 1], way[:, 0]))
    apart = np.einsum("iab,ijb->ija", turns, places[None] - places[:, None])
    passing = np.einsum("iab,ijb->ija", turns, velocities[None] - velocities[:, None])
    far = np.hypot(apart[:, :, 0], apart[:, :, 1])
    seen = np.where(apart[:, :, 0] < -0.3, np.inf, far)
    np.fill_diagonal(seen, np.inf)
    if len(places) < SEEN:
        wide = ((0, 0), (0, SEEN - len(places)))
        seen = np.pad(seen, wide, constant_values=np.inf)
        far = np.pad(far, wide, constant_values=1.0)
        apart, passing = (np.pad(one, (*wide, (0, 0))) for one in (apart, passing))
    near = np.argsort(seen, axis=1, kind="stable")[:, :SEEN]
    fade = np.exp(-np.take_along_axis(seen, near, axis=1) / REACH_M)[:, :, None]
    length = np.maximum(np.take_along_axis(far, near, axis=1), 0.05)[:, :, None]
    towards = np.take_along_axis(apart, near[:, :, None], axis=1) / length * fade
    moving = np.take_along_axis(passing, near[:, :, None], axis=1) * fade
    own = np.einsum("iab,ib->ia", turns, velocities)
    distance = np.minimum(np.hypot(way[:, 0], way[:, 1]), 5.0)
    parts = [own, distance, towards.reshape(len(own), -1), moving.reshape(len(own), -1)]
    return np.column_stack(parts), turns


def walkers_as_pairs(experiments: tuple[Experiment, ...]) -> Recording:
    """A pair for each person and step: what it sees, and its change of velocity in m/s.

    A take is a person; what is held out together is an experiment.
    """
    parts, groups, known = [], [], 0
    for number, experiment in enumerate(experiments):
        places = experiment.positions
        for now in range(1, len(places) - 1):
            there = np.flatnonzero(~np.isnan(places[now - 1 : now + 1, :, 0]).any(axis=0))
            velocities = (places[now, there] - places[now - 1, there]) / experiment.dt_s
            states, turns = perceive(places[now, there], velocities, experiment.goals[there])
            after = (places[now + 1, there] - places[now, there]) / experiment.dt_s
            changes = np.einsum("iab,ib->ia", turns, after - velocities)
            stays = ~np.isnan(changes[:, 0])
            who = there[stays] + known
            parts.append(Pairs(states[stays], changes[stays], who, np.full(len(who), now)))
            groups.append(np.full(len(who), number))
        known += places.shape[1]
    whole, held = join_pairs(parts), np.concatenate(groups)
    order = np.lexsort((whole.steps, whole.takes))
    starts = np.zeros(known, dtype=np.int64)
    first, at = np.unique(whole.takes[order], return_index=True)
    starts[first] = whole.steps[order][at]
    steps = whole.steps - starts[whole.takes]
    pairs = Pairs(whole.states[order], whole.actions[order], whole.takes[order], steps[order])
    return Recording("Jülich walkers", pairs, held[order], experiments[1].dt_s)


class ConstantVelocity:
    """Nobody changes velocity."""

    def predict(self, states: Array) -> Array:
        """No change for states (rows, n)."""
        return np.zeros((len(states), 2))


class StraightToGoal:
    """Everybody turns to the goal at once and keeps the speed."""

    def predict(self, states: Array) -> Array:
        """The change of velocity for states (rows, n), x towards the goal."""
        speed = np.hypot(states[:, 0], states[:, 1])
        return np.column_stack([speed - states[:, 0], -states[:, 1]])


def displacement(learner: Any, experiment: Experiment) -> Array:
    """Mean distance in m to where people were over AHEAD steps, one for each person and window.

    Every 2 * AHEAD steps all who are there are rolled out together from their positions and
    velocities; nobody's future is known but the goal. Those are scored who stay that long.
    """
    places, errors = experiment.positions, []
    for start in range(1, len(places) - AHEAD, 2 * AHEAD):
        there = np.flatnonzero(~np.isnan(places[start - 1 : start + 1, :, 0]).any(axis=0))
        if len(there) == 0:
            continue
        now, goals = places[start, there].copy(), experiment.goals[there]
        velocities = (now - places[start - 1, there]) / experiment.dt_s
        off = np.empty((AHEAD, len(there)))
        for ahead in range(AHEAD):
            states, turns = perceive(now, velocities, goals)
            changes = np.einsum("iba,ib->ia", turns, np.asarray(learner.predict(states)))
            walks = np.hypot(*(goals - now).T) > ARRIVED_M
            velocities = velocities + np.where(walks[:, None], changes, 0.0)
            now = now + velocities * experiment.dt_s
            off[ahead] = np.hypot(*(now - places[start + 1 + ahead, there]).T)
        stayed = ~np.isnan(off).any(axis=0)
        errors.append(off[:, stayed].mean(axis=0))
    return np.concatenate(errors)
