"""Flights: what a rollout did, world by world, and the figures that follow."""

import numpy as np
import pytest

from evastudio.evaluation.flight import (
    Flight,
    Logbook,
    figures_of,
    path_features,
    turning,
    velocities_of,
)
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds
from evastudio.world.snapshot import Snapshot

SEEDS = world_seeds(4, 5)


def flown(scene, seeds=SEEDS, max_steps=120):
    log = Logbook(scene)
    result = roll_out(scene, find_pilot("scripted:human"), seeds, max_steps=max_steps, watcher=log)
    return log.flights(), result


def test_a_flight_is_the_same_alone_and_in_a_batch(asteroids):
    scene = asteroids(density=8.0)
    together, result = flown(scene)
    assert [len(flight.actions) for flight in together] == result.steps.tolist()
    for seed, flight in zip(SEEDS, together, strict=True):
        (alone,), _ = flown(scene, [seed])
        np.testing.assert_array_equal(alone.actions, flight.actions)
        np.testing.assert_array_equal(alone.clearances, flight.clearances)
        for name, array in {**alone.moments.fixed, **alone.moments.moving}.items():
            np.testing.assert_array_equal(array, flight.moments[name])
        assert figures_of(scene, alone) == pytest.approx(figures_of(scene, flight), nan_ok=True)


def test_clearance_is_the_distance_from_hull_to_rock(asteroids):
    scene = asteroids(density=8.0)
    (flight, *_), _ = flown(scene)
    for moment in (0, 40, len(flight.actions) - 1):
        apart = flight.moments["rocks"][moment] - flight.moments["position"][moment]
        nearest = np.sqrt((apart**2).sum(axis=1)).min() - 4.0
        expected = nearest if nearest <= scene.clear_m else np.inf
        assert flight.clearances[moment] == pytest.approx(expected)


def made(scene, clearances):
    moments = len(clearances)
    start = scene.worlds([1]).take(np.zeros(moments, dtype=np.int64))
    return Flight(start, np.zeros((moments, 2)), np.array(clearances))


def test_near_misses_are_counted_once_each(asteroids):
    scene = asteroids()
    figures = figures_of(scene, made(scene, [np.inf, 0.5, 0.2, 3.0, 0.9, np.inf]))
    assert (figures["near_misses"], figures["closest_m"]) == (2.0, 0.2)
    figures = figures_of(scene, made(scene, [np.inf] * 6))
    assert np.isnan(figures["near_misses"])
    assert np.isnan(figures["closest_m"])


def test_turning_is_the_rate_at_which_the_direction_changes():
    angles = np.array([0.0, 0.1, 0.3, 0.3])
    velocities = np.stack([np.cos(angles), np.sin(angles)], axis=1) * [[1.0], [2.0], [3.0], [4.0]]
    np.testing.assert_allclose(turning(velocities, 0.5), [0.2, 0.4, 0.0], atol=1e-7)
    velocities[1] = 0.0
    np.testing.assert_allclose(turning(velocities, 0.5), [0.0, 0.0, 0.0], atol=1e-7)


def test_features_hold_pace_turning_clearance_and_action(asteroids):
    scene = asteroids(density=8.0)
    (flight, *_), _ = flown(scene)
    features = path_features(scene, flight)
    assert features.shape == (len(flight.actions) - 2, 5)
    assert np.isfinite(features).all()
    np.testing.assert_allclose(features[:, 0], 10.0)
    np.testing.assert_array_equal(features[:, 3:], flight.actions[1:-1])


def test_a_scene_that_has_no_position_stays_where_it_is(asteroids):
    scene = asteroids()
    moments = Snapshot({}, {"level": np.arange(6.0)})
    flight = Flight(moments, np.zeros((6, 2)), np.full(6, np.inf))
    np.testing.assert_array_equal(velocities_of(scene, flight), np.zeros((5, 2)))


def test_a_rollout_without_worlds_has_no_flights(asteroids):
    assert Logbook(asteroids()).flights() == []
