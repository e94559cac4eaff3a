"""The street: people come, cross, keep apart and go."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import shipped
from evastudio.world.check import check_file
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot, stack

FILE = shipped() / "scenes" / "street.py"
STREET = load_scene_file(FILE)
DT = STREET.dt_s


def straight_on(count: int, steps: int) -> np.ndarray:
    """Paths (steps, count, 2) side by side to the east at 1 m/s."""
    paths = np.zeros((steps, count, 2))
    paths[..., 0] = DT * np.arange(steps)[:, None]
    paths[..., 1] = 2.0 * np.arange(count)
    return paths


def world(paths: np.ndarray, goals: np.ndarray | None = None) -> tuple[Scene, Snapshot, np.ndarray]:
    scene = STREET(people=paths.shape[1])
    ends = paths[-1] if goals is None else goals
    ground = straight_on(1, 60)[:, 0]
    start, actions = scene.retraced(paths, np.nan_to_num(ends), ground)
    return scene, start, actions


def test_it_keeps_the_rules_of_scenes() -> None:
    assert [found.problem for found in check_file(FILE) if found.problem] == []


def test_more_people_than_fit_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="400 people do not fit on a square of 8 m"):
        STREET(people=400, size=8)


@pytest.mark.parametrize("style", ["careful", "hurried", "shy"])
def test_scripted_people_arrive_and_hardly_touch(style: str) -> None:
    scene, pilot, seeds = STREET(people=30), find_pilot(f"scripted:{style}"), [1, 2]
    snapshot, memory = scene.worlds(seeds), pilot.begin(scene, seeds)
    near, steps = 0, 150
    for _ in range(steps):
        actions, memory = pilot.act(scene, snapshot, memory)
        snapshot = scene.step(snapshot, actions)
        apart = snapshot["position"][:, :, None] - snapshot["position"][:, None]
        far = np.hypot(apart[..., 0], apart[..., 1]) + 10.0 * np.eye(30)
        near += int((far.min(axis=2) < 0.3).sum())
    assert snapshot["leg"].mean() > 3.5
    assert near / (2 * 30 * steps * DT / 60) < 2.0  # steps a person and minute


def test_people_come_and_go_as_recorded() -> None:
    paths = straight_on(3, 12)
    paths[:4, 1] = np.nan  # comes late
    paths[8:, 2] = np.nan  # goes early
    goals = paths[-1].copy()
    goals[2] = paths[7, 2]
    scene, moment, actions = world(paths, goals)
    for step, action in enumerate(actions):
        seen = ~np.isnan(paths[step : step + 2, :, 0]).any(axis=0)
        np.testing.assert_array_equal(moment["present"][0] > 0, seen)
        np.testing.assert_allclose(moment["position"][0, seen], paths[step + 1, seen], atol=1e-9)
        np.testing.assert_allclose(moment["velocity"][0, seen], [[1.0, 0.0]] * seen.sum())
        moment = scene.step(moment, action[None])


def test_who_is_not_there_is_not_seen_and_not_drawn() -> None:
    paths = straight_on(2, 12)
    paths[:6, 1] = np.nan
    scene, start, _ = world(paths)
    view = scene.perceptions["goal"]
    assert not view.perceive(start).states[0, 0, 3:].any()
    there = start.after(present=np.ones((1, 2), dtype=np.int64))
    assert view.perceive(there).states[0, 0, 3:].any()
    drawn = {body.name: len(body.positions) for body in scene.bodies(start)}
    both = {body.name: len(body.positions) for body in scene.bodies(there)}
    assert both["figure_shadow"] == 2 * drawn["figure_shadow"] == 2


def test_turned_and_moved_people_perceive_the_same() -> None:
    scene = STREET(people=12)
    before = scene.worlds([5])
    angle, shift = 0.7, np.array([3.0, -8.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    after = Snapshot(
        {**before.fixed, "goals": before["goals"] @ turn.T + shift},
        {
            **before.moving,
            "position": before["position"] @ turn.T + shift,
            "velocity": before["velocity"] @ turn.T,
            "heading": before["heading"] + angle,
        },
    )
    for view in scene.perceptions.values():
        states = view.perceive(before).states
        np.testing.assert_allclose(view.perceive(after).states, states, atol=1e-9)


def test_free_ground_ends_where_nobody_walks() -> None:
    scene, start, _ = world(straight_on(1, 20))
    free = scene.perceptions["walls"].perceive(start).states[0, 0, 15:]
    ahead, _, _, left, right = free
    assert ahead == 2.0
    assert left < 0.5
    assert right < 0.5


def test_faces_follow_feet_but_not_a_shuffle() -> None:
    scene, start, _ = world(straight_on(1, 5))
    view = scene.perceptions["goal"]
    frame = view.perceive(start).frame
    back = view.to_world(frame, np.array([[[-1.05, 0.0]]]))  # from 1 m/s to a step backwards
    assert abs(back[0, 0, 0]) < 0.5
    side = view.to_world(frame, np.array([[[-1.0, 1.0]]]))  # to 1 m/s to the left
    np.testing.assert_allclose(side[0, 0], [np.pi / 2, 1.0, 0.0], atol=1e-9)


def lived(scene: Scene, snapshot: Snapshot, actions: np.ndarray) -> tuple[Snapshot, np.ndarray]:
    """The moments of one world in which everybody acts as `actions` (steps, N, 3) say."""
    moments = [snapshot]
    for step in actions:
        moments.append(scene.step(moments[-1], step[None]))
    return stack(moments[:-1]), actions


def test_touches_pace_and_detours_are_measured() -> None:
    """Two walk straight by each other, one of them through a third, who stands."""
    paths = np.zeros((30, 3, 2))
    along = DT * np.arange(30)
    paths[:, 0, 0] = along
    paths[:, 1] = (5.0, 0.1)
    paths[:, 2] = np.column_stack([11.6 - along, np.full(30, 6.0)])
    ends = paths[-1] + (0.0, 3.0) * (np.arange(3) == 2)[:, None]
    scene, start, actions = world(paths, ends)
    moments, actions = lived(scene, start, actions)
    told = scene.measures(moments, actions)
    minutes = 3 * len(actions) * DT / 60
    assert told["touches_per_minute"] == pytest.approx(2 / minutes)
    assert told["metres_per_second"] == pytest.approx(2 / 3)
    assert told["standing"] == pytest.approx(1 / 3)
    closest = scene.clearance(moments)
    assert closest.min() == pytest.approx(np.hypot(0.2, 0.1) - 0.3, abs=0.02)
    assert (closest < scene.near_m).sum() in (2, 3)


def test_a_way_round_is_a_detour_and_a_straight_one_is_none() -> None:
    straight = np.column_stack([1.2 * DT * np.arange(40), np.zeros(40)])
    bent = straight.copy()
    bent[:, 1] = 4.0 * np.sin(np.linspace(0.0, np.pi, 40))
    for path, expected in ((straight, 1.0), (bent, 1.11)):
        scene, start, actions = world(path[:, None])
        moments, actions = lived(scene, start, actions)
        assert scene.measures(moments, actions)["detour"] == pytest.approx(expected, abs=0.03)
    assert np.isnan(scene.measures(moments.take(slice(0, 3)), actions[:3])["detour"])
