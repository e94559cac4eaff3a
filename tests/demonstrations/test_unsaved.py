"""Stores that really refuse: what was recorded meanwhile is written afterwards, each pair once."""

from __future__ import annotations

import gc
import os
import shutil
import subprocess
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.spill_file import BEGIN, FRAME
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.unsaved import take_in, unsaved
from evastudio.errors import StorageError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from tests.demonstrations.recording import add, tried
from tests.postgres import Postgres

Waiting = tuple[Store, int, Path]
LOCK = """
import sqlite3, sys
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute("begin exclusive")
print("locked", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.5)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "store.db"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "unsaved"


@pytest.fixture
def own_postgres() -> Iterator[Postgres]:
    """A server that may be killed."""
    server = Postgres(durable=True)
    try:
        server.start()
        yield server
    finally:
        server.remove()


def begun(store: Store, scene: Scene, name: str, folder: Path) -> tuple[int, Recorder, Snapshot]:
    """A new session of that name, and its recorder in a take that begins at the snapshot."""
    session = store.create_session(scene, name, "test", 0.0)
    recorder = Recorder(store, session, folders=[folder])
    snapshot = scene.worlds([1])
    recorder.begin(scene, snapshot, 1, "test", 0.0)
    return session, recorder, snapshot


def add_the_same(
    recorder: Recorder, scene: Scene, snapshot: Snapshot, first: int, count: int
) -> None:
    """Pairs that only differ in their number: much to write in little time."""
    states = scene.perception().perceive(snapshot).states
    for number in range(first, first + count):
        recorder.add(states, np.zeros((1, 2)), snapshot.after(steps=np.array([number])))
    tried(recorder)


def memory_held(work: Callable[[], None]) -> int:
    """Bytes that `work` leaves in memory."""
    tracemalloc.start()
    work()
    gc.collect()
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return held


def whole(store: Store, take: int, pairs: int) -> bool:
    """Whether a take has these pairs, each once and in order."""
    return np.array_equal(store.load_take(take).snapshots["steps"], np.arange(pairs))


def left_by_a_closed_recorder(scene: Scene, file: Path, folder: Path, pairs: int = 14) -> Path:
    """What is left of a take of session 1 where the store cannot be written at all."""
    with Store(f"sqlite:///file:{file}?mode=ro&uri=true") as store:
        recorder = Recorder(store, 1, folders=[folder])
        recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
        add(recorder, scene, scene.worlds([1]), pairs)
        recorder.end("crossed", 1.0)
        tried(recorder)
        assert recorder.problem is not None
        assert str(folder) in recorder.problem
        assert "readonly" in recorder.problem
        recorder.close(2.0, patience_s=0.0)
    (left,) = recorder.left
    return left


@pytest.fixture
def waiting(scene: Scene, file: Path, folder: Path) -> Iterator[Waiting]:
    """An open store, a session of it, and what is left of a take that it could not be told of."""
    with Store(f"sqlite:///{file}") as store:
        session = store.create_session(scene, "Waiting", "test", 0.0)
        yield store, session, left_by_a_closed_recorder(scene, file, folder)


def take_in_again(store: Store, copy: Path, left: Path) -> None:
    """Take in what was left, as `copy` has it, whether or not it was taken in before."""
    left.parent.mkdir(exist_ok=True)
    shutil.copy(copy, left)
    take_in(store, [left.parent])


def test_a_take_for_a_read_only_store_is_taken_in_later(folder: Path, waiting: Waiting) -> None:
    store, session, left = waiting
    assert store.takes(session) == []
    (taken,) = take_in(store, [folder])
    assert (taken.path, taken.takes, taken.pairs) == (left, 1, 14)
    assert not folder.exists()
    (take,) = store.takes(session)
    assert (take.pairs, take.outcome) == (14, "crossed")
    assert whole(store, take.id, 14)


@pytest.mark.parametrize("again", ["nothing of it", "its beginning", "all of it"])
def test_what_a_killed_studio_had_written_is_not_written_again(
    folder: Path, waiting: Waiting, again: str
) -> None:
    store, session, left = waiting
    copy = folder.parent / "copy"
    shutil.copy(left, copy)
    if again == "its beginning":
        left.write_bytes(left.read_bytes()[:-2000])
    if again != "nothing of it":
        take_in(store, [folder])
    take_in_again(store, copy, left)
    (take,) = store.takes(session, trashed=None)
    assert (take.pairs, take.outcome) == (14, "crossed")
    assert whole(store, take.id, 14)


def test_a_take_killed_before_its_first_pairs_leaves_no_trace(
    folder: Path, waiting: Waiting
) -> None:
    store, session, left = waiting
    data, end = left.read_bytes(), 0
    for _ in ("header", "beginning"):
        end += FRAME.size + FRAME.unpack_from(data, end)[0]
    left.write_bytes(data[:end])
    (found,) = unsaved([folder], store.identity)
    assert found.spilled is not None
    assert [entry.kind for entry in found.spilled.entries] == [BEGIN]
    take_in(store, [folder])
    assert store.takes(session, trashed=None) == []
    assert not folder.exists()


def test_a_take_in_the_trash_stays_there_and_a_deleted_one_gone(
    folder: Path, waiting: Waiting
) -> None:
    store, session, left = waiting
    copy = folder.parent / "copy"
    shutil.copy(left, copy)
    left.write_bytes(left.read_bytes()[:-2000])
    take_in(store, [folder])
    (take,) = store.takes(session)
    assert 0 < take.pairs < 14
    store.trash_take(take.id, 1.0)
    take_in_again(store, copy, left)
    (take,) = store.takes(session, trashed=True)
    assert take.pairs == 14
    store.empty_trash(session)
    take_in_again(store, copy, left)
    assert store.takes(session, trashed=None) == []
    assert not folder.exists()


def test_takes_whose_session_is_gone_are_kept_beside(
    scene: Scene, file: Path, folder: Path
) -> None:
    with Store(f"sqlite:///{file}") as store:
        recorder = Recorder(store, 7, folders=[folder])
        recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
        add(recorder, scene, scene.worlds([1]), 14)
        tried(recorder)
        assert recorder.problem is not None
        assert "no session 7" in recorder.problem
        recorder.close(2.0, patience_s=0.0)
        (left,) = recorder.left
        take_in(store, [folder])
        assert not left.exists()
        assert [path.name for path in folder.iterdir()] == [left.name + ".kept"]
        assert unsaved([folder], store.identity) == []


def test_a_store_that_still_refuses_leaves_everything_where_it_waits(
    scene: Scene, file: Path, folder: Path
) -> None:
    with Store(f"sqlite:///{file}") as store:
        store.create_session(scene, "Still", "test", 0.0)
    left = left_by_a_closed_recorder(scene, file, folder)
    before = left.read_bytes()
    with Store(f"sqlite:///file:{file}?mode=ro&uri=true") as store:
        with pytest.raises(StorageError):
            take_in(store, [folder])
        assert [found.path for found in unsaved([folder], store.identity)] == [left]
    assert left.read_bytes() == before


def test_another_program_that_locks_the_store_loses_nothing_and_no_memory(
    scene: Scene, file: Path, folder: Path
) -> None:
    with Store(f"sqlite:///{file}?timeout=0.05") as store:
        session, recorder, snapshot = begun(store, scene, "Locked", folder)
        snapshot = add(recorder, scene, snapshot, 12)
        tried(recorder)
        with subprocess.Popen(
            [sys.executable, "-c", LOCK, str(file)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        ) as other:
            assert other.stdout is not None
            assert other.stdout.readline()
            snapshot = add(recorder, scene, snapshot, 8)
            tried(recorder)
            assert recorder.problem is not None
            assert "locked" in recorder.problem
            assert str(folder) in recorder.problem
            (path,) = folder.iterdir()
            add_the_same(recorder, scene, snapshot, 20, 500)
            before = path.stat().st_size
            held = memory_held(lambda: add_the_same(recorder, scene, snapshot, 520, 2500))
            assert held < (path.stat().st_size - before) / 5
            other.communicate()
        tried(recorder)
        assert recorder.problem is None
        recorder.end("crossed", 1.0)
        recorder.close(1.0)
        (take,) = store.takes(session)
        assert (take.pairs, take.outcome) == (3020, "crossed")
        assert whole(store, take.id, 3020)
    assert not folder.exists()


def test_a_database_server_killed_in_a_take_loses_nothing(
    scene: Scene, own_postgres: Postgres, folder: Path
) -> None:
    with Store(own_postgres.url(own_postgres.create_database())) as store:
        session, recorder, snapshot = begun(store, scene, "Killed", folder)
        snapshot = add(recorder, scene, snapshot, 20)
        tried(recorder)
        own_postgres.kill()
        snapshot = add(recorder, scene, snapshot, 20)
        tried(recorder)
        assert recorder.problem is not None
        assert str(folder) in recorder.problem
        own_postgres.start()
        tried(recorder)
        assert recorder.problem is None
        snapshot = add(recorder, scene, snapshot, 20)
        tried(recorder)
        own_postgres.restart()
        add(recorder, scene, snapshot, 20)
        recorder.end("crossed", 1.0)
        recorder.close(1.0)
        assert recorder.problem is None
        (take,) = store.takes(session)
        assert (take.pairs, take.outcome) == (80, "crossed")
        assert whole(store, take.id, 80)


def test_a_server_made_read_only_in_a_take_loses_nothing(
    scene: Scene, own_postgres: Postgres, folder: Path
) -> None:
    def read_only(value: str) -> None:
        own_postgres.execute(f"ALTER SYSTEM SET default_transaction_read_only = {value}")
        own_postgres.execute("SELECT pg_reload_conf()")

    with Store(own_postgres.url(own_postgres.create_database())) as store:
        session, recorder, snapshot = begun(store, scene, "Read-only", folder)
        snapshot = add(recorder, scene, snapshot, 6)
        tried(recorder)
        read_only("on")
        while recorder.problem is None:  # until the server has read its settings again
            snapshot = add(recorder, scene, snapshot, 6)
            tried(recorder)
        assert "read-only" in recorder.problem
        with own_postgres.connect() as other:
            other.execute("SET default_transaction_read_only = off")
            other.execute("ALTER SYSTEM RESET default_transaction_read_only")
            other.execute("SELECT pg_reload_conf()")
        while recorder.problem is not None:
            tried(recorder)
        recorder.close(1.0)
        (take,) = store.takes(session)
        assert take.pairs == recorder.pairs
        assert whole(store, take.id, take.pairs)


def test_a_file_that_was_made_and_never_written_does_not_stay(file: Path, folder: Path) -> None:
    folder.mkdir()
    with Store(f"sqlite:///{file}") as store:
        old, new = (folder / f"{store.identity}-000000-{name}.unsaved" for name in ("old", "new"))
        for path in (old, new):
            path.touch()
        long_ago = new.stat().st_mtime - 3600
        os.utime(old, (long_ago, long_ago))
        assert take_in(store, [folder]) == []
    assert [path.name for path in folder.iterdir()] == [new.name]
