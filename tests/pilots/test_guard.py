"""A guarded pilot sends nobody where there is no way, and is the same pilot else."""

from __future__ import annotations

import numpy as np
import pytest

import evastudio
from evastudio.errors import NotFoundError
from evastudio.live.piloting import load_pilot
from evastudio.pilots.guard import GuardedPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import Workspace, shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
IMPACT_S = 1.0


def watched(scene, pilot, seeds, steps):
    """The snapshots before each step, the actions, and the last snapshot."""
    seen = []
    roll_out(scene, pilot, seeds, max_steps=steps, watcher=lambda _, *moment: seen.append(moment))
    return seen


@pytest.mark.parametrize(
    "name", ["crowd-hurried", "crowd-shy", "crowd-and-boulder", "scripted:hurried"]
)
def test_nobody_is_ever_blocked(name: str, workspace: Workspace) -> None:
    scene = CROWD(people=120, side=20)
    pilot = load_pilot(workspace, f"guarded:{name}", scene)
    assert pilot.name == f"guarded:{name}"
    moments = watched(scene, pilot, world_seeds(1, 3), 80)
    assert not moments[-1][0]["blocked"].any()


def test_whoever_has_a_way_does_as_the_pilot_would(workspace: Workspace) -> None:
    scene = CROWD(people=120, side=20)
    bare = load_pilot(workspace, "crowd-hurried", scene)
    kept = turned = 0
    for snapshot, actions in watched(scene, GuardedPilot(bare), [5, 6], 40):
        memory = {
            "seed": np.array([5, 6], dtype=np.uint64),
            "step": snapshot["steps"],
        }
        meant, _ = bare.act(scene, snapshot, memory)
        refused = scene.step(snapshot, meant)["blocked"] > snapshot["blocked"]
        same = (actions == meant).all(axis=2)
        assert (same == ~refused).all()
        assert (actions[refused, 1] == 0.0).all()
        assert (np.abs(actions[refused, 0]) == 1.0).all()
        kept, turned = kept + same.sum(), turned + refused.sum()
    assert kept > turned > 0


def test_it_turns_to_the_freer_side() -> None:
    scene = CROWD(people=3, side=9)
    start = scene.worlds([0])
    walking = np.zeros((1, 3, 6))
    walking[0, 0, 1] = 1.0
    for beside, turn in ((5, -1.0), (3, 1.0)):
        spots = np.array([[(4, 4), (5, 4), (5, beside)]])
        start = start.after(position=spots * 0.7, heading=np.zeros((1, 3)))
        assert scene.instead(start, walking)[0, 0].tolist() == [turn, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_those_who_flee_are_let_run(workspace: Workspace) -> None:
    scene = CROWD(people=80, side=12)
    moments = watched(scene, find_pilot("scripted:startled"), [7], 20)
    fled = 0
    for snapshot, actions in moments:
        if snapshot["boulder"][0, 2] >= IMPACT_S - scene.dt_s:
            assert np.array_equal(scene.instead(snapshot, actions), actions)
            fled += 1
    assert fled > 5


def test_where_nobody_stands_in_the_way_a_guard_changes_nothing(asteroids) -> None:
    scene = asteroids()
    pilot = find_pilot("scripted:careful")
    bare, guarded = (roll_out(scene, one, [3, 4]) for one in (pilot, GuardedPilot(pilot)))
    assert np.array_equal(bare.steps, guarded.steps)
    assert np.array_equal(bare.turn, guarded.turn)


def test_guarded_pilots_are_evaluated_like_any(workspace: Workspace) -> None:
    names = ["guarded:crowd-shy", "guarded:scripted:shy"]
    result = evastudio.evaluate(workspace, names, worlds=1, options={"people": 20, "length": 10})
    assert result["scene"]["name"] == "crowd"
    assert set(result["policies"]) == set(names)


@pytest.mark.parametrize("name", ["guarded:", "guarded:nobody", "guarded:guarded:crowd-shy"])
def test_a_guard_of_nobody_is_not_found(name: str, workspace: Workspace) -> None:
    with pytest.raises(NotFoundError):
        load_pilot(workspace, name, CROWD())
