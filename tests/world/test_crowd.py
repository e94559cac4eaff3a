"""The crowd: nobody walks through anybody, the boulder scatters them, shipped policies serve."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning.policy_files import load_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.scenery.fleeing import fleeing
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import world_seeds
from evastudio.world.snapshot import stack

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
CELL, IMPACT_S = 0.7, 1.0


def cells(scene, snapshot):
    """Which cell everybody stands in, (worlds, N)."""
    where = np.rint(snapshot["position"] / CELL).astype(int) % scene.side
    return where[:, :, 0] + scene.side * where[:, :, 1]


def policy_pilot(name):
    return PolicyPilot(load_policy(shipped() / "policies" / f"{name}.safetensors"), name)


def walked(scene, pilot, seeds, steps):
    """The snapshots of `steps` decisions."""
    snapshot, memory = scene.worlds(seeds), pilot.begin(scene, seeds)
    moments = [snapshot]
    for _ in range(steps):
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
        moments.append(snapshot)
    return moments


@pytest.mark.parametrize("pilot", ["scripted:hurried", "scripted:shy"])
def test_nobody_ever_shares_a_cell(pilot) -> None:
    scene = CROWD(people=60, side=12)
    for snapshot in walked(scene, find_pilot(pilot), [3, 4], 60):
        for world in cells(scene, snapshot):
            assert len(set(world)) == 60


def test_of_several_who_claim_a_cell_one_goes_and_the_others_are_blocked() -> None:
    scene = CROWD(people=3, side=9)
    start = scene.worlds([0])
    spots = np.array([[(2, 4), (4, 4), (8, 8)]])
    facing = np.array([[0.0, np.pi, 0.0]])
    start = start.after(position=spots * CELL, heading=facing)
    go = np.zeros((1, 3, 6))
    go[:, :2, 1] = 1.0
    after = scene.step(start, go)
    moved = np.abs(after["position"] - start["position"]).max(axis=2)[0] > 0
    assert moved.sum() == 1
    assert after["blocked"][0].tolist() == [*(~moved[:2]).astype(int).tolist(), 0]


def test_what_is_measured_of_a_crowd_is_what_its_people_do() -> None:
    """For a minute one asks for the cell of another who stands there, and one turns to and fro."""
    scene = CROWD(people=3, side=9)
    moment = scene.worlds([0]).after(
        position=np.array([[(2, 4), (3, 4), (8, 8)]]) * CELL, heading=np.zeros((1, 3))
    )
    moments, actions = [], []
    for step in range(121):
        chosen = np.zeros((1, 3, 6))
        chosen[0, 0, 1] = 1.0
        chosen[0, 2, 0] = (-1.0) ** step
        moments.append(moment)
        actions.append(chosen)
        moment = scene.step(moment, chosen)
    told = scene.measures(stack(moments), np.concatenate(actions))
    assert told["blocked_per_minute"] == pytest.approx(120 / 3)
    assert told["stuck_s"] == told["still_s"] == pytest.approx(60.0)
    assert told["cells_per_minute"] == pytest.approx(1.0)
    assert told["dithering"] == pytest.approx(1 / 3)
    assert told["standing"] == told["turning"] == pytest.approx(1 / 3)


def test_two_do_not_cross_at_a_corner() -> None:
    scene = CROWD(people=2, side=9)
    start = scene.worlds([0])
    start = start.after(
        position=np.array([[(4, 4), (5, 4)]]) * CELL, heading=np.array([[np.pi / 4, 3 * np.pi / 4]])
    )
    go = np.zeros((1, 2, 6))
    go[:, :, 1] = 1.0
    assert scene.step(start, go)["blocked"].sum() == 1


def test_who_leaves_on_one_side_comes_back_on_the_other() -> None:
    scene = CROWD(people=2, side=5)
    start = scene.worlds([0])
    start = start.after(position=np.array([[(4, 2), (0, 2)]]) * CELL, heading=np.zeros((1, 2)))
    go = np.zeros((1, 2, 6))
    go[:, 0, 1] = 1.0
    assert scene.step(start, go)["blocked"][0, 0] == 1
    go[:, 1, 1] = 1.0
    free = start.after(position=np.array([[(4, 2), (2, 2)]]) * CELL)
    assert cells(scene, scene.step(free, go))[0].tolist() == [0 + 5 * 2, 3 + 5 * 2]


def test_more_people_than_cells_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="26 people do not fit on 5 x 5 = 25 cells"):
        CROWD(people=26, side=5)


def test_the_boulder_knocks_over_who_is_near_and_the_others_flee() -> None:
    scene = CROWD(people=200, side=40)
    seeds = world_seeds(5, 3)
    start = scene.worlds(seeds)
    drop = np.zeros((3, 200, 6))
    drop[:, 0, 2] = 1.0
    drop[:, 0, 3:5] = start["position"][:, 0] + (6.0, 0.0)
    snapshot = scene.step(start, drop)
    pilot = policy_pilot("crowd-fleeing")
    while (snapshot["boulder"][:, 2] < IMPACT_S).all():
        snapshot = scene.step(snapshot, np.zeros((3, 200, 6)))
    apart = snapshot["position"] - snapshot["boulder"][:, None, :2]
    near = np.hypot(apart[..., 0], apart[..., 1])
    assert ((snapshot["hit"] == 1) == (near < 3.5)).all()
    assert snapshot["hit"].any(axis=1).all()
    frightened = (near < 20.0) & (snapshot["hit"] == 0)
    memory = pilot.begin(scene, seeds)
    errors = []
    for step in range(8):
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
        apart = snapshot["position"] - snapshot["boulder"][:, None, :2]
        away = np.arctan2(apart[..., 1], apart[..., 0])
        off = np.abs(np.remainder(snapshot["heading"] - away + np.pi, 2 * np.pi) - np.pi)
        if step >= 1:  # within a second
            assert (snapshot["speed"][frightened] > 2.0).all()
            errors.append(np.degrees(off[frightened]))
    assert np.mean(errors) < 2.0


@pytest.mark.parametrize("style", ["hurried", "shy"])
def test_a_crowd_of_a_shipped_policy_keeps_moving(style) -> None:
    scene = CROWD(people=50, side=20)
    moments = walked(scene, policy_pilot(f"crowd-{style}"), [1, 2], 240)
    minutes = 240 * scene.dt_s / 60
    assert moments[-1]["blocked"].mean() / minutes < 8.0
    places = np.stack([cells(scene, moment) for moment in moments])
    visited = [len(set(places[:, world, who])) for world in range(2) for who in range(50)]
    assert np.mean(visited) > 50


def test_a_take_is_learned_from_where_its_perception_applies() -> None:
    scene = CROWD(people=20, side=10)
    moments = walked(scene, find_pilot("scripted:startled"), [7], 12)
    calm = [bool(scene.perceptions["paths"].applies(moment)[0]) for moment in moments]
    wild = [bool(scene.perceptions["boulder"].applies(moment)[0]) for moment in moments]
    assert calm == [moment["boulder"][0, 2] < IMPACT_S for moment in moments]
    assert not any(both for both in zip(calm, wild, strict=True) if all(both))
    assert any(calm)
    assert any(wild)


def test_a_boulder_on_the_left_and_on_the_right_are_one_and_turn_one_away_from_it() -> None:
    scene = CROWD(people=2, side=9)
    view = scene.perceptions["boulder"]
    start = scene.worlds([0]).after(
        position=np.zeros((1, 2, 2)),
        heading=np.array([[-0.4, 0.4]]),
        boulder=np.array([[3.0, 0.0, 2.0]]),
    )
    percept = view.perceive(start)
    np.testing.assert_allclose(percept.states[0], [(np.cos(0.4), np.sin(0.4))] * 2)
    flight = view.to_world(percept.frame, np.array([[(-0.8, 1.0), (-0.8, 1.0)]]))
    assert flight[0, :, 0].tolist() == [-0.8, 0.8]
    away = fleeing(start, scene.action.size, 1.0)
    assert (np.sign(flight[..., 0]) == np.sign(away[..., 0])).all()


def test_between_decisions_nobody_jumps() -> None:
    scene = CROWD(people=40, side=15)
    moments = walked(scene, find_pilot("scripted:startled"), [2], 12)
    for before, after in pairwise(moments):
        frames = [scene.interpolate(before, after, share) for share in np.arange(16) / 15]
        ground = scene.side * CELL
        for earlier, later in pairwise([before, *frames, after]):
            shift = later["position"] - earlier["position"]
            shift = shift - np.rint(shift / ground) * ground
            assert np.abs(shift).max() < 0.22  # starting, one is up to a third faster for a moment


def test_clumsy_hands_drop_no_boulder_and_hesitate_on_the_spot() -> None:
    scene = CROWD(people=20)
    pilot, seeds = find_pilot("scripted:human"), world_seeds(1, 6)
    snapshot, memory = scene.worlds(seeds), pilot.begin(scene, seeds)
    for _ in range(60):
        resting = memory["resting"] > 1
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
        assert not actions[..., 2:].any()
        assert (actions[resting, :, 1] <= 0.5).all()
    assert (snapshot["boulder"][:, 2] < 0.0).all()


def test_a_crowd_that_is_paused_is_drawn_as_it_was() -> None:
    scene = CROWD(people=30, side=20)
    moments = walked(scene, find_pilot("scripted:hurried"), [4], 8)
    before, after = moments[-2], moments[-1]
    drawn = {body.name: body for body in scene.bodies(scene.interpolate(before, after, 1.0))}
    for body in scene.bodies(after):
        if body.name.startswith("figure"):
            np.testing.assert_allclose(body.positions, drawn[body.name].positions, atol=0.02)
