"""Takes made to be suspicious in each way are, and good ones are not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.records import TakeData, TakeRecord
from evastudio.demonstrations.suspicion import Figures, figures_of, suspicions
from evastudio.pilots.scripted import find_pilot
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot, stack
from evastudio.world.spaces import Array

DT = 1 / 15


@pytest.fixture(scope="module")
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.5)


def made(scene: Scene, actions: Array) -> TakeData:
    world = scene.worlds([1])
    fixed = {
        name: np.broadcast_to(one, (len(actions), *one.shape[1:]))
        for name, one in world.fixed.items()
    }
    moving = {name: np.repeat(one, len(actions), axis=0) for name, one in world.moving.items()}
    return TakeData(Snapshot(fixed, moving), np.zeros((len(actions), 1)), actions)


def record(
    id_: int, pairs: int, outcome: str | None = "crossed", trashed: bool = False
) -> TakeRecord:
    return TakeRecord(
        id_,
        1,
        id_,
        1,
        5,
        {},
        "person",
        pairs,
        round(pairs * DT, 6),
        outcome,
        0.0,
        trashed,
        None,
        "",
    )


def told(
    scene: Scene, takes: list[TakeRecord], figures: dict[int, Figures]
) -> dict[int, list[str]]:
    found = suspicions(scene.successes, takes, figures)
    return {take: [remark.kind for remark in remarks] for take, remarks in found.items()}


def flown(scene: Scene, seed: int) -> Figures:
    """Of the careful demonstrator, to the end of the world."""
    moments, actions = [], []

    def watch(_: object, snapshot: Snapshot, chosen: Array) -> None:
        moments.append(snapshot)
        actions.append(chosen)

    roll_out(scene, find_pilot("scripted:careful"), [seed], watcher=watch)
    return figures_of(scene, TakeData(stack(moments), np.zeros((1, 1)), np.concatenate(actions)))


def test_what_is_wrong_with_a_take_by_itself_is_said(scene: Scene) -> None:
    full, rest = scene.action.high, np.zeros(2)
    weave = np.sin(np.arange(300) / 9.0)[:, None] * full * 0.6
    held = np.tile([full[0], 0.1 * full[1]], (300, 1))
    takes = {
        1: (record(1, 20), weave[:20]),
        2: (record(2, 300), np.tile(rest, (300, 1))),
        3: (record(3, 300), held),
        4: (record(4, 50, "hit"), weave[:50]),
        5: (record(5, 50, None), weave[:50]),
        6: (record(6, 300, "hit"), weave),
        7: (record(7, 10, "hit"), np.tile(rest, (10, 1))),
    }
    figures = {id_: figures_of(scene, made(scene, actions)) for id_, (_, actions) in takes.items()}
    records = [one for one, _ in takes.values()]
    assert told(scene, records, figures) == {
        1: ["short"],
        2: ["still"],
        3: ["held"],
        4: ["early"],
        7: ["short", "still"],
    }
    (remark,) = suspicions(scene.successes, records, figures)[4]
    assert remark.says == "It went wrong after 3.3 s already."


def test_demonstrations_that_are_alike_are_not_suspicious(scene: Scene) -> None:
    figures = {id_: flown(scene, 40 + id_) for id_ in range(1, 9)}
    assert told(scene, [record(id_, 400) for id_ in figures], figures) == {}


def test_a_take_that_is_steered_otherwise_is_unlike_the_others(scene: Scene) -> None:
    figures = {id_: flown(scene, 40 + id_) for id_ in range(1, 9)}
    one = figures[1]
    figures[9] = Figures(one.rest, one.held, 4.0 * one.effort, one.haste)
    figures[10] = Figures(one.rest, one.held, one.effort, 6.0 * one.haste)
    figures[11] = Figures(one.rest, one.held, 0.05 * one.effort, one.haste)
    records = [record(id_, 400) for id_ in figures]
    found = suspicions(scene.successes, records, figures)
    assert {take: remark.says for take, (remark,) in found.items()} == {
        9: "Unlike your other takes: steered much more.",
        10: "Unlike your other takes: much more abrupt.",
        11: "Unlike your other takes: steered much less.",
    }
    assert told(scene, records[:4] + records[8:9], figures) == {}  # too few to compare with
    trashed = [record(id_, 400, trashed=id_ < 6) for id_ in figures]
    assert 9 not in told(scene, trashed, figures)
