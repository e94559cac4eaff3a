"""What waits in files is saved as soon as the store works again, with nobody asking for it."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable

import numpy as np

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.live.rescue import Rescue
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene


def test_a_rescue_goes_on_until_the_store_takes_everything(
    workspace: Workspace, asteroids: Callable[..., Scene]
) -> None:
    scene = asteroids(density=0.5)
    with Store(workspace.store_url + "?timeout=0.05") as store:
        session = store.create_session(scene, "Rescued", "test", 0.0)
        other = sqlite3.connect(workspace.root / "studio.db", isolation_level=None)
        other.execute("begin exclusive")
        recorder = Recorder(store, session, folders=workspace.unsaved)
        snapshot = scene.worlds([1])
        recorder.begin(scene, snapshot, 1, "test", 0.0)
        for _ in range(9):
            states = scene.perception().perceive(snapshot).states
            recorder.add(states, np.zeros((1, 2)), snapshot)
        recorder.close(1.0, patience_s=0.0)
        rescue = Rescue(store, workspace.unsaved)
        rescue.begin()
        rescue.wait(0.2)
        assert recorder.left[0].exists()
        other.execute("rollback")
        other.close()
        rescue.wait(60.0)
        assert [take.pairs for take in store.takes(session)] == [9]
        assert not recorder.left[0].exists()
        rescue.begin()
        rescue.close()
