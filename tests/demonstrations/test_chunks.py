"""Chunks: written once, joined when a take has ended, and read as the same pairs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from sqlalchemy import func, select, update

from evastudio.demonstrations import chunks, schema
from evastudio.demonstrations.records import TakeData
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, NotFoundError, StorageError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray

STEPS = 6


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=1.0)


@pytest.fixture
def take(store: Store, scene: Scene) -> int:
    session = store.create_session(scene, "A session", "test", 0.0)
    return store.begin_take(session, scene, "canonical", 3, "test", scene.worlds([3]).fixed, 1.0)


def part(scene: Scene, first: int) -> tuple[AnyArray, AnyArray, dict[str, AnyArray]]:
    rng = np.random.default_rng(first)
    moving = {
        name: np.repeat(array, STEPS, axis=0) for name, array in scene.worlds([3]).moving.items()
    }
    return rng.normal(size=(STEPS, 4)), rng.normal(size=(STEPS, 2)), moving


def short(scene: Scene) -> dict[str, AnyArray]:
    return {name: array[:2] for name, array in part(scene, 0)[2].items()}


def begin_like(store: Store, scene: Scene, take: int) -> int:
    session, fixed = store.take(take).session, scene.worlds([3]).fixed
    return store.begin_take(session, scene, "canonical", 3, "test", fixed, 1.0)


def append(store: Store, scene: Scene, take: int, count: int) -> TakeData:
    for first in range(0, count * STEPS, STEPS):
        store.append(take, first, *part(scene, first))
    return store.load_take(take)


def rows(store: Store) -> int:
    with store.engine.connect() as connection:
        return int(connection.execute(select(func.count()).select_from(schema.chunks)).scalar_one())


def test_a_take_that_has_ended_is_the_same_in_few_chunks(
    store: Store, scene: Scene, take: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = append(store, scene, take, 25)
    assert rows(store) == 25
    monkeypatch.setattr(chunks, "JOINED_BYTES", 10_000)
    store.finish_take(take, "crossed", 9.0)
    assert 1 < rows(store) < 10
    monkeypatch.undo()
    store.finish_take(take, "crossed", 9.0)
    assert rows(store) == 1
    after = store.load_take(take)
    assert np.array_equal(before.states, after.states)
    assert np.array_equal(before.actions, after.actions)
    for name in before.snapshots.moving:
        assert np.array_equal(before.snapshots[name], after.snapshots[name])
    assert store.take(take).pairs == 150


def test_takes_are_read_together_as_one_by_one(store: Store, scene: Scene, take: int) -> None:
    others = [begin_like(store, scene, take) for _ in range(20)]
    for number, one in enumerate(others):
        append(store, scene, one, 1 + number % 3)
    store.append(others[1], 12, *(one[:2] for one in part(scene, 12)[:2]), short(scene))
    wanted = others[::-1]
    for one, data in zip(wanted, store.load_takes(wanted), strict=True):
        alone = store.load_take(one)
        assert np.array_equal(data.states, alone.states)
        assert len(data.actions) == store.take(one).pairs
        assert all(
            np.array_equal(data.snapshots[n], alone.snapshots[n]) for n in alone.snapshots.moving
        )
    with pytest.raises(NotFoundError, match=f"no take {take}"):
        list(store.load_takes([others[0], take]))


def test_pairs_written_again_are_there_once(store: Store, scene: Scene, take: int) -> None:
    append(store, scene, take, 2)
    append(store, scene, take, 3)
    assert store.take(take).pairs == 18
    states, actions, moving = part(scene, 0)
    with pytest.raises(ConflictError):
        store.append(take, 0, states + 1.0, actions, moving)


def test_a_damaged_chunk_stays_as_it_is(store: Store, scene: Scene, take: int) -> None:
    append(store, scene, take, 3)
    with store.engine.begin() as connection:
        damaged = update(schema.chunks).where(schema.chunks.c.first_step == STEPS)
        connection.execute(damaged.values(arrays=b"torn"))
    store.finish_take(take, "crossed", 9.0)
    assert rows(store) == 3
    assert store.take(take).outcome == "crossed"
    with pytest.raises(StorageError, match="damaged"):
        store.load_take(take)


def test_nothing_is_appended_to_a_take_that_was_deleted(
    store: Store, scene: Scene, take: int
) -> None:
    store.trash_take(take, 2.0)
    store.empty_trash(store.sessions()[0].id)
    with pytest.raises(NotFoundError, match="no take"):
        append(store, scene, take, 1)
