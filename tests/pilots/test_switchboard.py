"""Switchboards: the right policy acts for each character, whoever else is in the batch."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.switch import Entry, Switch
from evastudio.live.piloting import load_pilot, load_switchboard
from evastudio.pilots.lead import LeadPilot
from evastudio.pilots.marking import MarkingPilot
from evastudio.pilots.scripted import find_pilot
from evastudio.workspace import shipped
from evastudio.world.conditions import parse_condition
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
SEEDS = world_seeds(8, 3)


def board_of(workspace, scene, *entries):
    made = tuple(
        Entry(policy, None if text is None else parse_condition(text, scene))
        for policy, text in entries
    )
    identity = {"name": scene.name, "version": scene.version}
    return load_switchboard(workspace, Switch(made, identity), scene)


def struck(scene, seeds, at):
    """Worlds in which the boulder has just hit the ground."""
    snapshot = scene.worlds(seeds)
    return snapshot.after(boulder=np.tile((*at, 1.0), (len(seeds), 1)))


def test_symbols_before_the_impact_and_numbers_after_it(workspace) -> None:
    """The shipped switch is crowd-hurried until the impact and crowd-fleeing from then on."""
    scene = CROWD(people=12, side=12)
    both = load_pilot(workspace, "crowd-and-boulder", scene)
    before, after = (
        load_pilot(workspace, f"crowd-{name}", scene) for name in ("hurried", "fleeing")
    )
    calm = scene.worlds(SEEDS)
    memory = both.begin(scene, SEEDS)
    chosen, later = both.act(scene, calm, memory)
    assert np.array_equal(chosen, before.act(scene, calm, before.begin(scene, SEEDS))[0])
    wild = struck(scene, SEEDS, (3.0, 3.0))
    chosen, _ = both.act(scene, wild, later)
    assert np.array_equal(chosen, after.act(scene, wild, {})[0])


def test_each_character_switches_for_itself(workspace) -> None:
    scene = CROWD(people=12, side=12)
    board = board_of(
        workspace, scene, ("crowd-fleeing", "event:impact and boulder<3"), ("straight", None)
    )
    snapshot = struck(scene, SEEDS, (4.0, 4.0))
    actions, _ = board.act(scene, snapshot, board.begin(scene, SEEDS))
    near = np.hypot(*(snapshot["position"] - 4.0).transpose(2, 0, 1)) < 3.0
    assert 0 < near.sum() < near.size
    assert (actions[near][:, 1] > 0.5).all()
    assert (actions[~near] == 0.0).all()


def test_what_holds_once_holds_for_good_and_the_first_entry_wins(workspace) -> None:
    scene = CROWD(people=4, side=12)
    entries = (
        ("straight", "once after:1s and x<3"),
        ("crowd-shy", "after:2s"),
        ("crowd-hurried", None),
    )
    board = board_of(workspace, scene, *entries)
    memory = board.begin(scene, [1])
    west = scene.worlds([1]).after(position=np.full((1, 4, 2), 1.4))
    east = west.after(position=np.full((1, 4, 2), 5.6))
    acted = []
    for snapshot in (west, west, east, east, east):
        acting, _ = board.acting(scene, snapshot, memory)
        acted.append(int(acting[0, 0]))
        _, memory = board.act(scene, snapshot, memory)
    assert acted == [2, 2, 2, 2, 1]
    _, memory = board.act(scene, west, memory)
    assert board.acting(scene, east, memory)[0].tolist() == [[0, 0, 0, 0]]


@pytest.mark.parametrize(
    "entries",
    [
        (("crowd-shy", "x<4"), ("crowd-hurried", None)),
        (("scripted:careful", "x<4"), ("crowd-shy", "after:8s"), ("crowd-hurried", None)),
        (("crowd-fleeing", "once event:impact and boulder<6"), ("crowd-hurried", None)),
    ],
)
def test_a_world_in_a_batch_is_that_world_alone(workspace, entries) -> None:
    scene = CROWD(people=8, side=10)
    board = board_of(workspace, scene, *entries)

    def tracks(seeds):
        kept = [[] for _ in seeds]

        def watch(alive, snapshot, actions):
            for row, world in enumerate(alive):
                kept[world].append((snapshot["position"][row], actions[row]))

        roll_out(scene, board, seeds, max_steps=40, watcher=watch)
        return kept

    together = tracks(SEEDS)
    for number, seed in enumerate(SEEDS):
        for alone, batched in zip(tracks([seed])[0], together[number], strict=True):
            assert np.array_equal(alone[0], batched[0])
            assert np.array_equal(alone[1], batched[1])


def test_others_can_follow_a_switch_while_one_leads(workspace) -> None:
    scene = CROWD(people=6, side=10)
    others = load_pilot(workspace, "crowd-and-boulder", scene)
    pilot = LeadPilot(find_pilot("scripted:surprised"), others)
    roll_out(scene, pilot, SEEDS[:1], max_steps=80)


def test_a_marker_marks_when_its_rule_begins_and_ceases(workspace) -> None:
    scene = CROWD(people=6, side=10)
    rule = parse_condition("region:0,0,3,6", scene)
    marks, inside = [], []

    def watch(_, snapshot, actions):
        x, y = snapshot["position"][0, 0] % 7.0
        inside.append(-0.01 < x < 3.0 and -0.01 < y < 6.0)
        marks.append(actions[0, 0, 5])
        assert (actions[0, 1:, 5] == 0).all()

    roll_out(scene, MarkingPilot(find_pilot("scripted:hurried"), rule), [4], watcher=watch)
    changed = np.diff(np.array(inside, dtype=int), prepend=0) != 0
    assert changed.sum() > 2
    assert np.array_equal(np.array(marks) > 0.5, changed)


def test_what_cannot_act_is_refused_in_a_sentence(workspace, asteroids) -> None:
    scene = CROWD(people=3, side=9)
    with pytest.raises(ConflictError, match="Entry 1 of switch 'switch' cannot act"):
        board_of(workspace, scene, ("asteroids-careful", "after:1s"), ("crowd-shy", None))
    with pytest.raises(InvalidInputError, match="'crowd-and-boulder' is itself a switch"):
        board_of(workspace, scene, ("guarded:crowd-and-boulder", "after:1s"), ("straight", None))
    with pytest.raises(ConflictError, match="was made for scene 'crowd'"):
        load_pilot(workspace, "crowd-and-boulder", asteroids())
    marker = MarkingPilot(find_pilot("straight"), parse_condition("after:1s", asteroids()))
    with pytest.raises(ConflictError, match="no signal 'mark'"):
        marker.begin(asteroids(), [1])
    with pytest.raises(InvalidInputError, match="the last has none"):
        board_of(workspace, scene, ("crowd-shy", None), ("straight", None))
