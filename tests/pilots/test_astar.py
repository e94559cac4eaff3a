"""A*: its plans are flown as planned, are the best there are, and stop when they are told to."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.pilots.astar import AStarPilot
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds

SEEDS = world_seeds(11, 8)


def planned(pilot, scene, snapshot, world=0):
    return pilot.plan(scene, scene.course(snapshot), world)


def flown(scene, snapshot, actions):
    for action in actions:
        assert scene.outcome(snapshot)[0] == 0
        snapshot = scene.step(snapshot, action[None])
    return snapshot


def ahead(scene, x=40.0):
    """Worlds at `x`, away from what is there."""
    snapshot = scene.worlds(SEEDS[:1])
    position = np.array([[x, 3.0, -2.0]])
    far = np.abs(snapshot["rocks"] - position[:, None]).max(axis=2) > 6.0
    rocks = np.where(far[:, :, None], snapshot["rocks"], (-90.0, 0.0, 0.0))
    moved = snapshot.after(position=position)
    return replace(moved, fixed={**moved.fixed, "rocks": rocks})


def test_nearly_every_dense_field_is_crossed(asteroids):
    scene = asteroids(density=6.0)
    rollout = roll_out(scene, AStarPilot(), SEEDS[:3])
    assert (rollout.outcomes == scene.outcomes.index("crossed")).all()
    assert rollout.steps.mean() * scene.dt_s < 36.6


def test_the_search_flies_as_the_scene_does(asteroids):
    """One physics: where the plan ends, the scene brings the ship, past the same rocks."""
    scene = asteroids(density=10.0)
    for seed in SEEDS:
        start = scene.worlds([seed]).after(position=np.array([[30.0, 5.0, 0.0]]))
        if scene.outcome(start)[0] != 0:
            continue
        plan = planned(AStarPilot(nodes=2000), scene, start)
        after = flown(scene, start, plan.actions)
        assert scene.outcome(after)[0] == 0
        assert len(plan.actions) * scene.dt_s == pytest.approx(plan.cost_s)
        assert not plan.finished or after["position"][0, 0] >= 70.0 - 1e-9


def test_nothing_in_the_way_means_straight_ahead(asteroids):
    scene = asteroids()
    start = scene.worlds(SEEDS[:1])
    empty = replace(start, fixed={**start.fixed, "rocks": start["rocks"] * 0.0 - 90.0})
    plan = planned(AStarPilot(sight_m=400.0), scene, empty)
    assert plan.finished
    assert not plan.actions.any()
    assert len(plan.actions) == 540
    assert plan.expanded == 135


def test_without_merging_it_finds_the_best_of_all_ways(asteroids):
    """All 729 ways of three primitives, flown by the scene."""
    scene = asteroids(density=10.0, half_width=30.0)
    start = ahead(scene)
    pilot = AStarPilot(nodes=5000, merge_m=0.0, sight_m=7.5)
    plan = planned(pilot, scene, start)
    assert plan.finished
    turns = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=2))) * scene.action.high
    ways = np.array(list(itertools.product(range(9), repeat=3)))
    batch = start.take(np.zeros(len(ways), dtype=np.int64))
    clear = np.ones(len(ways), dtype=bool)
    cost_s = np.full(len(ways), np.inf)
    for step in range(3 * pilot.hold):
        batch = scene.step(batch, turns[ways[:, step // pilot.hold]])
        clear &= scene.clearance(batch) >= pilot.berth_m
        arrived = clear & (batch["position"][:, 0] >= 47.5)
        cost_s[arrived] = np.minimum(cost_s[arrived], (step + 1) * scene.dt_s)
    assert plan.cost_s == pytest.approx(cost_s.min())


def test_a_budget_of_nodes_is_kept_and_repeats(asteroids):
    scene = asteroids(density=10.0)
    start = ahead(scene)
    for nodes in (1, 7, 60):
        plans = [planned(AStarPilot(nodes=nodes), scene, start) for _ in range(2)]
        assert plans[0].expanded <= nodes
        assert np.array_equal(plans[0].actions, plans[1].actions)
        assert plans[0].stored_bytes > 0


def test_a_budget_of_time_is_kept(asteroids):
    scene = asteroids(density=10.0)
    clock = itertools.count(0.0, 1.0)
    pilot = AStarPilot(nodes=100_000, seconds=3.0, clock=lambda: next(clock), sight_m=300.0)
    plan = planned(pilot, scene, ahead(scene))
    assert plan.expanded <= 300
    assert len(plan.actions) > 0


def test_every_search_can_be_watched(asteroids):
    """One in four decisions searches; the others follow."""
    plans = []
    pilot = AStarPilot(nodes=20, watch=plans.append)
    rollout = roll_out(asteroids(), pilot, SEEDS[:2], max_steps=40)
    assert len(plans) == 20
    assert rollout.steps.tolist() == [40, 40]
    assert all(0 < plan.expanded <= 20 and plan.stored_bytes > 0 for plan in plans)


def test_merging_makes_the_search_smaller(asteroids):
    scene = asteroids(density=10.0)
    start = ahead(scene)
    whole, merged = (
        planned(AStarPilot(nodes=20_000, sight_m=25.0, merge_m=merge), scene, start)
        for merge in (0.0, 1.0)
    )
    assert whole.finished
    assert merged.finished
    assert merged.expanded < whole.expanded
    assert merged.cost_s <= whole.cost_s + 0.2


def test_who_is_walled_in_flies_on_to_the_end(asteroids):
    """No plan at all is an action still, and the flight ends as it must."""
    scene = asteroids()
    start = scene.worlds(SEEDS[:1])
    wall = np.zeros_like(start["rocks"])
    grid = np.stack(np.meshgrid(np.arange(-30, 31, 4.0), np.arange(-30, 31, 4.0)), -1)
    grid = grid.reshape(-1, 2)
    wall[:, :, 0] = -90.0
    wall[0, : len(grid)] = np.column_stack([np.full(len(grid), 6.0), grid])
    plan = planned(AStarPilot(), scene, replace(start, fixed={**start.fixed, "rocks": wall}))
    assert not plan.finished
    assert len(plan.actions) <= 12


def test_a_scene_without_a_course_and_odd_settings_are_refused():
    crowd = load_scene_file(shipped() / "scenes" / "crowd.py")()
    with pytest.raises(NotFoundError, match="Scene 'crowd' is no course"):
        roll_out(crowd, AStarPilot(), SEEDS[:1])
    with pytest.raises(InvalidInputError, match="nodes=0"):
        AStarPilot(nodes=0)
    with pytest.raises(InvalidInputError, match="levels"):
        AStarPilot(levels=(2.0,))
