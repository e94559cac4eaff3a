"""The last seconds of a take, kept as one of its own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.trimming import keep_last
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.world.scene import Scene


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.5)


@pytest.fixture
def take(store: Store, scene: Scene) -> int:
    """60 steps, turning all the while."""
    session = store.create_session(scene, "Turning", "test", 0.0)
    recorder = Recorder(store, session)
    moment = scene.worlds([7])
    recorder.begin(scene, moment, 7, "person", 100.0)
    for step in range(60):
        action = np.array([[np.sin(step / 9), 0.2]])
        recorder.add(scene.perception().perceive(moment).states, action, moment)
        moment = scene.step(moment, action)
    recorder.close(0.0)
    return store.takes(session)[0].id


def test_the_last_seconds_are_a_take_that_replays(store: Store, scene: Scene, take: int) -> None:
    old, before = store.take(take), store.load_take(take)
    made = keep_last(store, take, 2.0, 500.0)
    new, after = store.take(made), store.load_take(made)
    assert (new.pairs, new.number, new.seed) == (30, 2, RECORDED)
    assert new.origin == Origin(30, take=take, seed=7)
    assert new.started_at == pytest.approx(102.0)
    assert store.take(take).trashed
    assert not new.trashed
    assert np.array_equal(after.actions, before.actions[30:])
    assert np.array_equal(after.states, before.states[30:])
    again = replay_take(scene, new, after)
    for name, array in after.snapshots.moving.items():
        assert np.array_equal(again[name], array), name
    store.restore_take(take)
    assert store.session(old.session).pairs == 90


@pytest.mark.parametrize("seconds", [0.0, -1.0, 4.0, 60.0, float("nan"), float("inf")])
def test_nothing_and_everything_are_refused(store: Store, take: int, seconds: float) -> None:
    with pytest.raises(InvalidInputError, match="cannot be kept apart"):
        keep_last(store, take, seconds, 0.0)
    assert not store.take(take).trashed


def test_a_take_that_is_not_there_is_not_found(store: Store) -> None:
    with pytest.raises(NotFoundError, match="no take"):
        keep_last(store, 99, 1.0, 0.0)


def test_notes_are_kept_and_checked(store: Store, take: int) -> None:
    assert store.take(take).note == ""
    store.note_take(take, "  too hasty\nin the middle ")
    assert store.take(take).note == "too hasty\nin the middle"
    for bad in ("x" * 2001, "nul\x00", "\x1b[31m"):
        with pytest.raises(InvalidInputError, match="note"):
            store.note_take(take, bad)
    with pytest.raises(NotFoundError):
        store.note_take(99, "lost")
