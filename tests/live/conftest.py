"""A stage that records, in a thin field."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.live.stage import Stage
from evastudio.world.scene import Scene


@pytest.fixture
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids(density=0.1)


@pytest.fixture
def stage(store: Store, scene: Scene) -> Iterator[Stage]:
    made = Stage(scene, 1, 0.0)
    made.recorder = Recorder(store, store.create_session(scene, "Stage", "test", 0.0))
    yield made
    made.recorder.close(0.0)
