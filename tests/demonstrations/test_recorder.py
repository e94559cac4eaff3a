"""The recorder streams, and a store that fails for a while loses nothing."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable

import numpy as np
import pytest

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from tests.demonstrations.recording import add, tried


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.5)


def test_pairs_reach_the_store_while_the_take_runs(store: Store, scene: Scene) -> None:
    session = store.create_session(scene, "Live", "test", 0.0)
    recorder = Recorder(store, session)
    snapshot = scene.worlds([1])
    recorder.begin(scene, snapshot, 1, "test", 0.0)
    assert store.takes(session) == []
    unwritten = []
    for _ in range(40):
        snapshot = add(recorder, scene, snapshot, 1)
        tried(recorder)
        takes = store.takes(session)
        unwritten.append(recorder.pairs - (takes[0].pairs if takes else 0))
    assert max(unwritten) * scene.dt_s < 0.5
    assert store.takes(session)[0].outcome is None
    recorder.close(1.0)
    assert store.takes(session)[0].pairs == 40


def test_a_discarded_take_comes_back(store: Store, scene: Scene) -> None:
    session = store.create_session(scene, "Undo", "test", 0.0)
    recorder = Recorder(store, session)
    recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
    add(recorder, scene, scene.worlds([1]), 10)
    assert recorder.can_discard
    assert recorder.discard(1.0)
    assert not recorder.discard(1.0)
    tried(recorder)
    assert store.session(session).takes_trashed == 1
    assert recorder.can_undo
    assert recorder.undo()
    assert not recorder.undo()
    tried(recorder)
    assert store.session(session).pairs == 10
    recorder.close(2.0)


def test_a_locked_store_is_told_and_nothing_is_lost(workspace: Workspace, scene: Scene) -> None:
    url = workspace.store_url + "?timeout=0.05"
    with Store(url) as store:
        session = store.create_session(scene, "Locked", "test", 0.0)
        recorder = Recorder(store, session)
        snapshot = scene.worlds([1])
        recorder.begin(scene, snapshot, 1, "test", 0.0)
        snapshot = add(recorder, scene, snapshot, 12)
        tried(recorder)
        other = sqlite3.connect(workspace.root / "studio.db", isolation_level=None)
        other.execute("begin exclusive")
        snapshot = add(recorder, scene, snapshot, 6)
        tried(recorder)
        assert recorder.problem is not None
        assert "goes on in memory" in recorder.problem
        other.execute("rollback")
        other.close()
        add(recorder, scene, snapshot, 7)
        recorder.end("crossed", 1.0)
        tried(recorder)
        assert recorder.problem is None
        recorder.close(1.0)
        take = store.takes(session)[0]
        assert (take.pairs, take.outcome) == (25, "crossed")
        assert np.array_equal(store.load_take(take.id).snapshots["steps"], np.arange(25))


def test_closing_waits_for_a_store_that_is_locked(workspace: Workspace, scene: Scene) -> None:
    with Store(workspace.store_url + "?timeout=0.05") as store:
        session = store.create_session(scene, "Busy", "test", 0.0)
        recorder = Recorder(store, session)
        other = sqlite3.connect(
            workspace.root / "studio.db", isolation_level=None, check_same_thread=False
        )
        other.execute("begin exclusive")
        recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
        add(recorder, scene, scene.worlds([1]), 3)
        recorder.end("crossed", 1.0)
        tried(recorder)
        assert recorder.problem is not None
        unlock = threading.Timer(0.2, lambda: other.execute("rollback"))
        unlock.start()
        recorder.close(1.0)
        unlock.join()
        other.close()
        assert recorder.problem is None
        assert [(take.pairs, take.outcome) for take in store.takes(session)] == [(3, "crossed")]


def test_a_pair_that_cannot_be_written_is_told(store: Store, scene: Scene) -> None:
    session = store.create_session(scene, "Odd", "test", 0.0)
    recorder = Recorder(store, session)
    snapshot = scene.worlds([1])
    recorder.begin(scene, snapshot, 1, "test", 0.0)
    recorder.add(np.array([["no number"]], dtype=object), np.zeros((1, 2)), snapshot)
    recorder.flush()
    tried(recorder)
    assert recorder.problem is not None
    recorder.close(1.0, patience_s=0.0)


def test_a_take_deleted_meanwhile_does_not_hold_up_the_next(store: Store, scene: Scene) -> None:
    session = store.create_session(scene, "Emptied", "test", 0.0)
    recorder = Recorder(store, session)
    recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
    add(recorder, scene, scene.worlds([1]), 10)
    recorder.discard(1.0)
    tried(recorder)
    assert store.empty_trash(session) == 1
    recorder.undo()
    recorder.begin(scene, scene.worlds([2]), 2, "test", 2.0)
    add(recorder, scene, scene.worlds([2]), 10)
    recorder.close(3.0)
    assert recorder.problem is None
    assert [take.pairs for take in store.takes(session)] == [10]


def test_a_closed_recorder_calls_nobody(store: Store, scene: Scene) -> None:
    recorder = Recorder(store, store.create_session(scene, "Closed", "test", 0.0))
    recorder.close(0.0)
    recorder.settle(lambda: pytest.fail("nobody waits for this"))
    recorder.close(0.0)


def test_an_empty_take_leaves_no_trace(store: Store, scene: Scene) -> None:
    session = store.create_session(scene, "Empty", "test", 0.0)
    recorder = Recorder(store, session)
    recorder.begin(scene, scene.worlds([1]), 1, "test", 0.0)
    recorder.discard(1.0)
    recorder.undo()
    recorder.close(1.0)
    assert recorder.problem is None
    assert store.takes(session, trashed=None) == []
