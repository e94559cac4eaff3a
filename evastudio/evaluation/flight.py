"""What a pilot did in one world, moment by moment, and the figures that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.evaluation.smoothness import log_dimensionless_jerk, spectral_arc_length
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot, moments_of
from evastudio.world.spaces import Array

FEATURES = ("pace", "turning", "clearance")
"""Components of `path_features` before those of the action."""


@dataclass(frozen=True)
class Flight:
    """One world as it was flown, or a take."""

    moments: Snapshot
    """Before each decision, along the axis of worlds, as in a take."""
    actions: Array
    """In the world's frame, shape (moments, ..., action size)."""
    clearances: Array
    """`Scene.clearance` at each moment, metres."""


class Logbook:
    """Collects flights from a rollout: a `Watcher`."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._alive: list[NDArray[np.int64]] = []
        self._moving: list[Mapping[str, AnyArray]] = []
        self._fixed: Mapping[str, AnyArray] = {}
        self._actions: list[Array] = []

    def __call__(self, alive: NDArray[np.int64], snapshot: Snapshot, actions: Array) -> None:
        if not self._alive:
            self._fixed = snapshot.fixed
        self._alive.append(alive)
        self._moving.append(snapshot.moving)
        self._actions.append(actions)

    def flights(self) -> list[Flight]:
        """One for each world, in order."""
        if not self._alive:
            return []
        worlds = np.concatenate(self._alive)
        order = np.argsort(worlds, kind="stable")
        ends = np.cumsum(np.bincount(worlds))
        moving = {
            name: np.concatenate([step[name] for step in self._moving])[order]
            for name in self._moving[0]
        }
        actions = np.concatenate(self._actions)[order]
        flights = []
        for world, (start, end) in enumerate(zip(np.r_[0, ends[:-1]], ends, strict=True)):
            fixed = {name: array[world] for name, array in self._fixed.items()}
            own = {name: array[start:end] for name, array in moving.items()}
            flights.append(flight_of(self._scene, fixed, own, actions[start:end]))
        return flights


def flight_of(
    scene: Scene, fixed: Mapping[str, AnyArray], moving: Mapping[str, AnyArray], actions: Array
) -> Flight:
    """The flight in one world: what is `fixed` in it, and what moves, with its moments."""
    moments = moments_of({name: array[None] for name, array in fixed.items()}, moving)
    return Flight(moments, actions, scene.clearance(moments))


def path_features(scene: Scene, flight: Flight) -> Array:
    """How the lead moves, moment by moment, for telling styles apart; (moments - 2, 3 + m).

    Pace, m/s; how fast the path turns, rad/s; clearance, m; and the action's components.
    """
    velocities = velocities_of(scene, flight)
    if len(velocities) < 2:
        return np.zeros((0, 3 + flight.actions.shape[-1]))
    clear = flight.clearances[1:-1]
    own = of_lead(flight.moments, flight.actions)[1:-1]
    pace = np.sqrt((velocities[1:] ** 2).sum(axis=1))
    columns = [pace, turning(velocities, scene.dt_s), np.minimum(clear, scene.clear_m)]
    return np.column_stack([*columns, own])


def figures_of(scene: Scene, flight: Flight) -> dict[str, float]:
    """The figures of a flight: those of any scene, and the scene's own. NaN where undefined."""
    velocities = velocities_of(scene, flight)
    clear = flight.clearances
    near = clear < scene.near_m
    begins = near & ~np.r_[False, near[:-1]]
    return {
        "closest_m": float(clear.min()) if np.isfinite(clear).any() else float("nan"),
        "near_misses": float(begins.sum()) if np.isfinite(clear).any() else float("nan"),
        "jerk": log_dimensionless_jerk(velocities, scene.dt_s),
        "arc_length": spectral_arc_length(turning(velocities, scene.dt_s), scene.dt_s),
        **scene.measures(flight.moments, flight.actions),
    }


def velocities_of(scene: Scene, flight: Flight) -> Array:
    """Of the lead between one moment and the next, (moments - 1, d), m/s."""
    return np.asarray(np.diff(scene.whereabouts(flight.moments), axis=0) / scene.dt_s)


def turning(velocities: Array, dt_s: float) -> Array:
    """How fast the direction of `velocities` (moments, d) changes, (moments - 1,), rad/s.

    Zero where it stands still before or after.
    """
    speeds = np.sqrt((velocities**2).sum(axis=1))
    product = speeds[1:] * speeds[:-1]
    dot = (velocities[1:] * velocities[:-1]).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(product > 0.0, dot / product, 1.0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)) / dt_s)
