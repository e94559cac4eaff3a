"""What a stage does to a recorder, without the stage."""

from __future__ import annotations

import threading

import numpy as np

from evastudio.demonstrations.recorder import Recorder
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot


def add(recorder: Recorder, scene: Scene, snapshot: Snapshot, count: int) -> Snapshot:
    """That many pairs from `snapshot` on; the moment after them."""
    for _ in range(count):
        actions = np.full((1, 2), 0.01)
        recorder.add(scene.perception().perceive(snapshot).states, actions, snapshot)
        snapshot = scene.step(snapshot, actions)
    return snapshot


def tried(recorder: Recorder) -> None:
    """Return once the recorder has tried to write what it was given."""
    done = threading.Event()
    recorder.settle(done.set)
    assert done.wait(60.0)
