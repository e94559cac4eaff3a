"""The session store keeps what it was given, and says what it cannot read."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import update

from evastudio.demonstrations import schema
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import TakeData
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError, StorageError
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene


def demonstrate(store: Store, session: int, scene: Scene, seed: int, steps: int) -> int:
    """Record a take of `steps` wobbling decisions; its id."""
    recorder = Recorder(store, session)
    snapshot = scene.worlds([seed])
    recorder.begin(scene, snapshot, seed, "test", 1.0)
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        actions = scene.action.clip(rng.normal(0.0, 0.05, (1, scene.action.size)))
        recorder.add(scene.perception().perceive(snapshot).states, actions, snapshot)
        snapshot = scene.step(snapshot, actions)
    recorder.end("crossed", 2.0)
    recorder.close(2.0)
    assert recorder.problem is None
    return store.takes(session)[-1].id


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=1.0)


@pytest.fixture
def session(store: Store, scene: Scene) -> int:
    return store.create_session(scene, "A session", "test", 0.0)


def test_counts_come_from_what_is_stored(store: Store, scene: Scene, session: int) -> None:
    demonstrate(store, session, scene, 1, 31)
    second = demonstrate(store, session, scene, 2, 14)
    record = store.session(session)
    assert (record.takes_kept, record.pairs, record.seconds) == (2, 45, 3.0)
    take = store.take(second)
    assert (take.number, take.seed, take.pairs, take.outcome) == (2, 2, 14, "crossed")
    assert take.options == {"density": 1.0, "half_width": 100.0}


def test_a_take_replays_bit_for_bit(store: Store, scene: Scene, session: int) -> None:
    take = demonstrate(store, session, scene, 2**52 + 7, 100)
    record, data = store.take(take), store.load_take(take)
    again = replay_take(scene, record, data)
    for name in (*data.snapshots.moving, *data.snapshots.fixed):
        assert data.snapshots[name].dtype == again[name].dtype
        assert np.array_equal(data.snapshots[name], again[name]), name
    states = np.concatenate(
        [scene.perception().perceive(again.take(slice(i, i + 1))).states for i in range(100)]
    )
    assert np.array_equal(states, data.states)
    assert np.array_equal(scene.perception().perceive(data.snapshots).states, data.states)


def test_a_take_replays_only_in_its_own_version_and_options(
    store: Store, scene: Scene, session: int, asteroids: Callable[..., Scene]
) -> None:
    take = demonstrate(store, session, scene, 5, 10)
    with pytest.raises(ConflictError, match="replays only in its own"):
        replay_take(asteroids(density=2.0), store.take(take), store.load_take(take))


def test_trash_leaves_out_restore_brings_back(store: Store, scene: Scene, session: int) -> None:
    take = demonstrate(store, session, scene, 1, 10)
    store.trash_take(take, 3.0)
    record = store.session(session)
    assert (record.takes_kept, record.takes_trashed, record.pairs) == (0, 1, 0)
    assert store.takes(session) == []
    assert [one.id for one in store.takes(session, trashed=True)] == [take]
    store.restore_take(take)
    assert store.session(session).pairs == 10


def test_only_emptying_the_trash_deletes(store: Store, scene: Scene, session: int) -> None:
    gone, kept = (demonstrate(store, session, scene, seed, 10) for seed in (1, 2))
    store.save_cleaning(session, {}, {gone: np.zeros(10, dtype=bool)}, 3.0)
    store.trash_take(gone, 4.0)
    assert store.empty_trash(session) == 1
    with pytest.raises(NotFoundError, match="no take"):
        store.take(gone)
    assert store.load_take(kept).actions.shape == (10, 2)


def test_cleanings_mark_and_are_undone(store: Store, scene: Scene, session: int) -> None:
    take = demonstrate(store, session, scene, 1, 20)
    mask = np.arange(20) % 3 == 0
    store.save_cleaning(session, {"n_neighbors": 9}, {take: mask}, 5.0)
    cleaning = store.session(session).cleaning
    assert cleaning is not None
    assert (cleaning.pairs, cleaning.removed, cleaning.stale) == (20, 7, False)
    assert np.array_equal(store.marks(session)[take], mask)
    assert store.session(session).pairs == 20
    demonstrate(store, session, scene, 2, 5)
    changed = store.session(session).cleaning
    assert changed is not None
    assert changed.stale
    assert store.undo_cleaning(session)
    assert store.session(session).cleaning is None
    assert store.marks(session) == {}
    assert not store.undo_cleaning(session)


def test_a_cleaning_leaves_out_takes_that_were_deleted_meanwhile(
    store: Store, scene: Scene, session: int
) -> None:
    gone, kept = (demonstrate(store, session, scene, seed, 5) for seed in (1, 2))
    store.trash_take(gone, 3.0)
    store.empty_trash(session)
    store.save_cleaning(session, {}, dict.fromkeys((gone, kept), np.ones(5, dtype=bool)), 4.0)
    assert list(store.marks(session)) == [kept]


def test_sessions_are_found_by_id_and_by_name(store: Store, scene: Scene, session: int) -> None:
    assert store.session(session).name == "A session"
    assert store.session(str(session)).id == session
    assert store.session("A session").id == session
    newer = store.create_session(scene, "A session", "test", 1.0)
    assert store.session("A session").id == newer
    with pytest.raises(NotFoundError, match="evastudio sessions"):
        store.session("Another")


@pytest.mark.parametrize("name", ["", "   ", "a\nb", "x" * 201, "\x00"])
def test_a_name_that_cannot_be_shown_is_refused(store: Store, scene: Scene, name: str) -> None:
    with pytest.raises(InvalidInputError, match="printable"):
        store.create_session(scene, name, "test", 0.0)


def test_what_was_written_is_there_for_the_next_who_opens(store_url: str, scene: Scene) -> None:
    with Store(store_url) as first:
        session = first.create_session(scene, "Kept", "test", 0.0)
        take = demonstrate(first, session, scene, 1, 12)
        before = first.load_take(take)
        identity = first.identity
    with Store(store_url) as second:
        after: TakeData = second.load_take(take)
        assert second.identity == identity
    assert np.array_equal(before.actions, after.actions)


def test_a_foreign_or_damaged_database_is_refused_and_left_alone(tmp_path: Path) -> None:
    text = tmp_path / "text.db"
    text.write_bytes(b"not a database at all, just text " * 100)
    with pytest.raises(StorageError, match="cannot be opened"):
        Store(f"sqlite:///{text}")
    assert text.read_bytes().startswith(b"not a database")

    other = tmp_path / "other.db"
    with sqlite3.connect(other) as connection:
        connection.execute("create table recipes (id integer)")
    connection.close()
    with pytest.raises(StorageError, match="other tables"):
        Store(f"sqlite:///{other}")


def test_a_truncated_store_is_refused(workspace: Workspace, scene: Scene) -> None:
    with Store(workspace.store_url) as store:
        session = store.create_session(scene, "Cut", "test", 0.0)
        demonstrate(store, session, scene, 1, 30)
    path = workspace.root / "studio.db"
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(StorageError, match="cannot be opened"):
        Store(workspace.store_url)


def test_damage_that_shows_only_later_is_told_as_a_sentence(
    workspace: Workspace, scene: Scene
) -> None:
    with Store(workspace.store_url) as store:
        session = store.create_session(scene, "Torn", "test", 0.0)
        demonstrate(store, session, scene, 1, 30)
    with sqlite3.connect(workspace.root / "studio.db") as connection:
        connection.execute("drop table chunks")
    connection.close()
    with Store(workspace.store_url) as store, pytest.raises(StorageError, match="cannot be used"):
        store.session(session)


def test_programs_that_open_a_new_store_at_once_share_it(store_url: str) -> None:
    together = threading.Barrier(8)

    def open_it(_: int) -> str:
        together.wait()
        with Store(store_url) as store:
            return store.identity

    with ThreadPoolExecutor(8) as threads:
        assert len(set(threads.map(open_it, range(8)))) == 1


def test_a_newer_store_is_refused(store_url: str) -> None:
    with Store(store_url) as store, store.engine.begin() as connection:
        connection.execute(update(schema.store).values(version=99))
    with pytest.raises(StorageError, match="version 99"):
        Store(store_url)


def begin(store: Store, session: int, scene: Scene, key: str | None = None) -> int:
    fixed = scene.worlds([1]).fixed
    return store.begin_take(session, scene, "canonical", 1, "test", fixed, 1.0, key=key)


def test_takes_and_sessions_come_in_pages(store: Store, scene: Scene, session: int) -> None:
    ids = [begin(store, session, scene) for _ in range(5)]
    store.trash_take(ids[1], 2.0)
    assert [take.id for take in store.takes(session, limit=2)] == [ids[0], ids[2]]
    assert [take.id for take in store.takes(session, after=ids[2], limit=2)] == ids[3:]
    assert [take.id for take in store.takes(session, None, after=ids[0], limit=2)] == ids[1:3]
    assert store.takes(session, after=ids[4]) == []
    more = [store.create_session(scene, f"Session {i}", "test", 0.0) for i in range(3)]
    assert [one.id for one in store.sessions(limit=2)] == [more[2], more[1]]
    assert [one.id for one in store.sessions(after=more[1])] == [more[0], session]
    assert store.sessions("crowd", limit=2) == []


def test_a_take_begun_again_with_its_key_is_the_same(
    store: Store, scene: Scene, session: int
) -> None:
    first = begin(store, session, scene, "a key")
    assert begin(store, session, scene, "a key") == first
    assert begin(store, session, scene, "another") != first
    assert begin(store, session, scene) != begin(store, session, scene)


def test_takes_begun_at_once_have_a_number_each(store_url: str, scene: Scene) -> None:
    writers, takes = 4, 10
    together = threading.Barrier(writers)
    with Store(store_url) as store:
        session = store.create_session(scene, "Busy", "test", 0.0)

    def write(_: int) -> None:
        with Store(store_url) as store:
            together.wait()
            for _ in range(takes):
                begin(store, session, scene)

    with ThreadPoolExecutor(writers) as threads:
        list(threads.map(write, range(writers)))
    with Store(store_url) as store:
        numbers = [take.number for take in store.takes(session)]
    assert sorted(numbers) == list(range(1, writers * takes + 1))


def test_a_take_brought_back_while_the_trash_is_emptied_is_whole_or_gone(
    store_url: str, scene: Scene
) -> None:
    together = threading.Barrier(2)
    with Store(store_url) as store, ThreadPoolExecutor(2) as threads:
        session = store.create_session(scene, "Trash", "test", 0.0)
        for seed in range(4):
            take = demonstrate(store, session, scene, seed, 10)
            store.trash_take(take, 3.0)

            def restore(take: int = take) -> bool:
                together.wait()
                try:
                    store.restore_take(take)
                except NotFoundError:
                    return False
                return True

            def empty() -> int:
                together.wait()
                return store.empty_trash(session)

            brought_back, emptied = threads.submit(restore), threads.submit(empty)
            assert brought_back.result() != bool(emptied.result())
            if brought_back.result():
                assert len(store.load_take(take).actions) == 10
                store.trash_take(take, 4.0)
                assert store.empty_trash(session) == 1


def test_a_take_needs_a_session(store: Store, scene: Scene) -> None:
    with pytest.raises(NotFoundError, match="no session 77"):
        begin(store, 77, scene)


@pytest.mark.parametrize("take", [0, -1, 2**31, 2**63, 2**70])
def test_numbers_that_no_take_has(store: Store, take: int) -> None:
    for ask in (store.take, store.load_take, store.restore_take):
        with pytest.raises(NotFoundError, match="no take"):
            ask(take)


def test_text_that_a_database_cannot_hold_is_refused(
    store: Store, scene: Scene, session: int
) -> None:
    for text in ("a\x00b", "\ud800"):
        with pytest.raises(InvalidInputError):
            store.create_session(scene, "Name", "test", 0.0, made_by=text)
        with pytest.raises(InvalidInputError):
            store.sessions(text)
        with pytest.raises(InvalidInputError):
            store.session(text)
        with pytest.raises(InvalidInputError):
            store.finish_take(begin(store, session, scene), text, 1.0)
    store.save_cleaning(session, {"text": "a\x00b"}, {}, 1.0)
    cleaning = store.session(session).cleaning
    assert cleaning is not None
    assert cleaning.settings == {"text": "a\x00b"}
