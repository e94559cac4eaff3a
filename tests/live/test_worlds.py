"""Headless worlds: stepped as rollouts step, recorded as people are, kept and brought back."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live import batch as batches
from evastudio.live import demonstrating
from evastudio.live import worlds as opened
from evastudio.live.batch import Batch
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot
from evastudio.live.saved import Saved
from evastudio.live.worlds import Worlds
from evastudio.workspace import Workspace, shipped
from evastudio.world.rollout import roll_out
from evastudio.world.snapshot import AnyArray, Snapshot, stack
from evastudio.world.spaces import Array

SPARSE = {"density": 0.5}


@pytest.fixture
def store_url(workspace: Workspace) -> str:
    """One database will do: takes are written by the recorder, which is tested on all."""
    return workspace.store_url


@pytest.fixture
def worlds(workspace: Workspace, store: Store) -> Iterator[Worlds]:
    of_a_server = replace(workspace, paths=False)
    made = Worlds(of_a_server, store, clock=lambda: 1e9)
    yield made
    made.close_all()


def same(one: Mapping[str, AnyArray], other: Mapping[str, AnyArray]) -> bool:
    return one.keys() == other.keys() and all(
        np.array_equal(array, other[name]) for name, array in one.items()
    )


@pytest.mark.parametrize(
    ("scene", "pilot", "options", "seeds"),
    [
        ("asteroids", "asteroids-careful", {"density": 1.5}, range(6)),
        ("asteroids", "scripted:human", SPARSE, [3]),
        ("crowd", "crowd-and-boulder", {}, [1, 2]),
        ("street", "street-people", {}, [4]),
    ],
)
def test_a_pilot_does_what_it_does_in_a_rollout_bit_for_bit(
    worlds: Worlds, workspace: Workspace, scene: str, pilot: str, options: Any, seeds: Any
) -> None:
    made = make_scene(workspace, scene, options)
    actor = load_pilot(workspace, pilot, made)
    last: dict[int, tuple[Snapshot, Array]] = {}

    def watch(alive: NDArray[np.int64], snapshot: Snapshot, actions: Array) -> None:
        for row, world in enumerate(alive):
            last[int(world)] = snapshot.take(slice(row, row + 1)), actions[row : row + 1]

    flown = roll_out(made, actor, list(seeds), max_steps=60, watcher=watch)
    ends = [made.step(*last[world]) for world in range(len(seeds))]
    batch = worlds.open(scene, list(seeds), options=options)
    for count in (1, 9, 50):
        seen = batch.play(pilot, count)
    assert np.array_equal(seen.outcomes, flown.outcomes)
    assert np.array_equal(seen.steps, flown.steps)
    saved = batch.save()
    assert same(saved.snapshot.moving, stack([Snapshot({}, one.moving) for one in ends]).moving)
    for row, end in enumerate(ends):
        assert np.array_equal(seen.states[row], made.perception().perceive(end).states[0])
        assert seen.progress[row] == made.progress(end)[0]


@pytest.mark.parametrize("own", [False, True])
def test_actions_of_a_program_do_what_a_policy_does(
    worlds: Worlds, workspace: Workspace, own: bool
) -> None:
    batch = worlds.open("asteroids", [5, 6], options=SPARSE)
    twin = worlds.open("asteroids", [5, 6], options=SPARSE)
    actor = load_pilot(workspace, "asteroids-careful", batch.scene)
    seen = batch.observe()
    for _ in range(30):
        if own:
            chosen = actor.policy.learner.decide(seen.states)  # type: ignore[attr-defined]
        else:
            chosen = actor.act(batch.scene, batch.save().snapshot, {})[0]
        seen = batch.step(chosen, own=own)
        played = twin.play("asteroids-careful")
    assert same(seen.arrays(), played.arrays())
    assert same(batch.save().snapshot.moving, twin.save().snapshot.moving)


def test_many_steps_at_once_are_those_steps_one_by_one(worlds: Worlds) -> None:
    actions = np.random.default_rng(0).uniform(-0.1, 0.1, (40, 3, 2))
    batch, twin = (worlds.open("asteroids", [1, 2, 3]) for _ in range(2))
    for row in actions:
        seen = batch.step(row)
    assert same(seen.arrays(), twin.step(actions).arrays())


def test_worlds_that_have_ended_stay_as_they_ended(worlds: Worlds) -> None:
    batch = worlds.open("asteroids", [1, 2], options=SPARSE)
    first = batch.play("straight", 10_000)
    assert first.outcomes.all()
    assert same(batch.step(np.ones((2, 2))).arrays(), first.arrays())
    assert same(
        batch.reset([2]).arrays(), worlds.open("asteroids", [2], options=SPARSE).observe().arrays()
    )


def test_in_a_crowd_the_lead_acts_alone_or_everybody_does(worlds: Worlds) -> None:
    one, all_ = (worlds.open("crowd", [1]) for _ in range(2))
    everybody = np.zeros((1, 60, 6))
    lead = np.array([[0.3, 0.0, 0.0, 0.0, 0.0, 0.0]])
    everybody[0, 0] = lead[0]
    everybody = one.scene.action.clip(everybody)
    for _ in range(5):
        assert same(one.step(lead).arrays(), all_.step(everybody).arrays())
    assert same(one.step(lead).arrays(), all_.step(everybody[None]).arrays())


# -- demonstrating -----------------------------------------------------------------------------


def test_what_a_program_does_is_a_take_that_replays_exactly(
    worlds: Worlds, workspace: Workspace, store: Store
) -> None:
    scene = make_scene(workspace, "asteroids", SPARSE)
    session = store.create_session(scene, "By program", "planner", 0.0)
    batch = worlds.open("asteroids", [7], options=SPARSE, session=session, pilot="planner 2")
    twin = worlds.open("asteroids", [7], options=SPARSE, perception="paper")
    rng = np.random.default_rng(1)
    while not batch.observe().outcomes.all():
        action = rng.uniform(-0.05, 0.05, (1, 2))
        batch.step(action)
        seen = twin.step(action)
    batch.reset([8])
    batch.step(np.zeros((5, 1, 2)))
    worlds.close(batch.name)
    whole, broken_off = store.takes(session)
    assert (whole.pilot, whole.seed, whole.pairs) == ("program:planner 2", 7, seen.steps[0])
    assert whole.outcome == scene.outcomes[seen.outcomes[0]]
    assert (broken_off.seed, broken_off.pairs, broken_off.outcome) == (8, 5, None)
    for take in (whole, broken_off):
        data = store.load_take(take.id)
        again = replay_take(scene, take, data)
        assert same(again.moving, data.snapshots.moving)
        assert np.array_equal(scene.perception().perceive(again).states, data.states)


def test_a_program_faster_than_the_store_waits_and_loses_nothing(
    worlds: Worlds, workspace: Workspace, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demonstrating, "AHEAD", 50)
    scene = make_scene(workspace, "asteroids", SPARSE)
    session = store.create_session(scene, "Fast", "planner", 0.0)
    batch = worlds.open("asteroids", [7], options=SPARSE, session=session)
    total = 0
    for seed in range(4):
        batch.reset([seed])
        total += int(batch.step(np.zeros((300, 1, 2))).steps[0])
    worlds.close(batch.name)
    takes = store.takes(session)
    assert sum(take.pairs for take in takes) == total
    assert [len(store.load_take(take.id).actions) for take in takes] == [t.pairs for t in takes]


def test_what_a_pilot_of_the_studio_does_is_no_demonstration(
    worlds: Worlds, workspace: Workspace, store: Store
) -> None:
    """A program takes over where a policy was: its take begins there, and replays from there."""
    scene = make_scene(workspace, "crowd")
    session = store.create_session(scene, "Taking over", "planner", 0.0)
    batch = worlds.open("crowd", [3], session=session)
    batch.play("crowd-and-boulder", 8)
    batch.step(np.zeros((4, 1, 60, 6)))
    batch.play("crowd-and-boulder", 2)
    batch.step(np.zeros((1, 6)))
    worlds.close(batch.name)
    first, second = store.takes(session)
    assert (first.pairs, second.pairs) == (4, 1)
    for take in (first, second):
        data = store.load_take(take.id)
        assert same(replay_take(scene, take, data).moving, data.snapshots.moving)
    assert store.load_take(first.id).snapshots["steps"][0] == 8


def test_a_demonstration_is_of_one_world_of_its_sessions_scene(
    worlds: Worlds, workspace: Workspace, store: Store
) -> None:
    session = store.create_session(make_scene(workspace, "crowd"), "Crowd", "planner", 0.0)
    with pytest.raises(ConflictError, match="Choose a session of this scene"):
        worlds.open("asteroids", [1], session=session)
    with pytest.raises(InvalidInputError, match="a demonstration is of one world"):
        worlds.open("crowd", [1, 2], session=session)
    with pytest.raises(InvalidInputError, match="printable"):
        worlds.open("crowd", [1], session=session, pilot="\n<script>")
    assert worlds.all() == []


# -- saving and restoring ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "pilot"), [("asteroids", "scripted:human"), ("crowd", "crowd-and-boulder")]
)
def test_worlds_go_on_elsewhere_as_if_nothing_had_been(
    worlds: Worlds, scene: str, pilot: str
) -> None:
    batch = worlds.open(scene, [1, 2])
    batch.play(pilot, 15)
    arrays = batch.save().arrays()
    expected = batch.play(pilot, 25)
    other = worlds.open(scene, [9])
    other.restore(Saved.of(arrays))
    assert other.seeds == (1, 2)
    assert same(other.play(pilot, 25).arrays(), expected.arrays())
    assert same(other.save().arrays(), batch.save().arrays())


def changed(arrays: Mapping[str, AnyArray], **other: AnyArray | None) -> dict[str, AnyArray]:
    new = {name.replace("_", "."): array for name, array in other.items()}
    return {name: array for name, array in {**arrays, **new}.items() if array is not None}


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"moving_position": np.full((1, 60, 2), np.nan)}, "NaN"),
        ({"moving_position": np.zeros((1, 59, 2))}, r"expected \(1, 60, 2\)"),
        ({"moving_position": np.zeros((1, 60, 2), np.float32)}, "float32"),
        ({"moving_position": None}, "lacks 'position'"),
        ({"moving_more": np.zeros(1)}, "unknown array 'more'"),
        ({"moving_lead": np.array([10**6])}, "led by a character"),
        ({"fixed_size": np.zeros((1, 60))}, "not those of its seeds"),
        ({"seeds": np.array([-1])}, "negative"),
        ({"seeds": np.zeros((1, 1), np.int64)}, "one int64"),
        ({"seeds": np.zeros(5000, np.int64)}, "for each world"),
        ({"steps": np.array([0.5])}, "one int64"),
        ({"about": None}, "no snapshot"),
        ({"about": np.frombuffer(b"[]", np.uint8)}, "no snapshot"),
        ({"about": np.frombuffer(b"[" * 10**5, np.uint8)}, "no snapshot"),
        ({"about": np.frombuffer(b'{"scene": {}, "pilot": 3}', np.uint8)}, "pilot"),
        ({"about": np.frombuffer(b'{"scene": {}, "pilot": null}', np.uint8)}, "same options"),
    ],
)
def test_what_is_no_moment_of_the_worlds_is_refused(
    worlds: Worlds, wrong: dict[str, Any], says: str
) -> None:
    batch = worlds.open("crowd", [1])
    before = batch.play("crowd-and-boulder", 3)
    arrays = batch.save().arrays(fixed=True)
    with pytest.raises(InvalidInputError, match=says):
        batch.restore(Saved.of(changed(arrays, **wrong)))
    assert same(batch.observe().arrays(), before.arrays())


def test_a_pilot_is_called_by_its_name_and_never_by_a_path(worlds: Worlds) -> None:
    batch = worlds.open("asteroids", [1])
    path = str(shipped() / "policies" / "asteroids-careful.safetensors")
    with pytest.raises(NotFoundError):
        batch.play(path)
    arrays = batch.save().arrays()
    about = json.loads(arrays["about"].tobytes())
    arrays["about"] = np.frombuffer(json.dumps({**about, "pilot": path}).encode(), np.uint8)
    with pytest.raises(NotFoundError):
        batch.restore(Saved.of(arrays))


def test_a_made_up_memory_is_refused(worlds: Worlds) -> None:
    batch = worlds.open("asteroids", [1])
    batch.play("scripted:human", 3)
    arrays = batch.save().arrays()
    for name, array in arrays.items():
        if name.startswith("memory."):
            with pytest.raises(InvalidInputError, match="memory"):
                batch.restore(Saved.of({**arrays, name: array[:0]}))
    with pytest.raises(InvalidInputError, match="no moment"):
        batch.restore(Saved.of({**arrays, "memory.step": np.array([-(10**9)])}))


# -- limits ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("actions", "says"),
    [
        (np.zeros(2), r"expected \(1, 2\), or \(steps, 1, 2\)"),
        (np.zeros((2, 2)), r"shape \(2, 2\)"),
        (np.zeros((0, 1, 2)), "0 steps"),
        (np.zeros((20_000, 1, 2)), "20000 steps"),
        ([[0.0], [0.0, 1.0]], "not a table"),
        (np.full((1, 2), np.inf), "NaN or infinite"),
    ],
)
def test_actions_that_do_not_fit_are_refused_and_nothing_moves(
    worlds: Worlds, actions: Any, says: str
) -> None:
    batch = worlds.open("asteroids", [1])
    with pytest.raises(InvalidInputError, match=says):
        batch.step(actions)
    assert batch.observe().steps[0] == 0


def test_only_so_much_is_opened(worlds: Worlds, monkeypatch: pytest.MonkeyPatch) -> None:
    for seeds in ([], [1] * 1025, [-1], [2**53]):
        with pytest.raises(InvalidInputError, match=r"seeds|Seeds"):
            worlds.open("asteroids", seeds)
    with pytest.raises(InvalidInputError, match="decisions"):
        worlds.open("crowd", [1] * 100).play("crowd-and-boulder", 1000)
    with pytest.raises(NotFoundError):
        worlds.open("asteroids", [1], perception="none")
    monkeypatch.setattr(batches, "MOST_BYTES", 1000)
    with pytest.raises(InvalidInputError, match="too large"):
        worlds.open("asteroids", [1])
    monkeypatch.setattr(opened, "MOST_BYTES", 1000)
    monkeypatch.undo()
    monkeypatch.setattr(opened, "MOST_OPEN", 1)
    with pytest.raises(ConflictError, match="already"):
        worlds.open("asteroids", [1])


def test_a_scene_that_fails_ends_the_take_and_not_the_batch(
    worlds: Worlds, workspace: Workspace, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = store.create_session(make_scene(workspace, "asteroids"), "Fails", "x", 0.0)
    batch: Batch = worlds.open("asteroids", [1], session=session)
    batch.step(np.zeros((3, 1, 2)))

    def broken(snapshot: Snapshot, actions: Array) -> Snapshot:
        raise RuntimeError("a scene of somebody's")

    monkeypatch.setattr(batch.scene, "step", broken)
    with pytest.raises(ConflictError, match="log tells why"):
        batch.step(np.zeros((1, 2)))
    monkeypatch.undo()
    assert batch.observe().steps[0] == 3
    batch.step(np.zeros((1, 2)))
    worlds.close(batch.name)
    assert [take.outcome for take in store.takes(session)] == [None, None]
    with pytest.raises(NotFoundError):
        worlds.get(batch.name)
    with pytest.raises(ConflictError, match="closed"):
        batch.observe()
