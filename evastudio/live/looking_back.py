"""What a person does with what was recorded: look back at it, go on from it, keep its end."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.trimming import keep_last
from evastudio.errors import ConflictError
from evastudio.live.headless import make_scene
from evastudio.live.pulse import PATIENCE_S
from evastudio.live.reel import Reel
from evastudio.live.stage import Stage
from evastudio.workspace import Workspace
from evastudio.world.snapshot import Snapshot

if TYPE_CHECKING:
    from evastudio.live.live_stage import LiveStage


class LookingBack:
    """The part of a live stage that reaches into the past. Callable from any thread."""

    def __init__(self, live: LiveStage, stage: Stage, workspace: Workspace, store: Store) -> None:
        self._live = live
        self._stage = stage
        self._workspace = workspace
        self._store = store

    def review(self, take: int | None = None, at_s: float = 0.0) -> None:
        """Look back at a take, or at the run that is on the stage, from `at_s` on."""
        self._live.begin_again()
        reel = self._stage.run.reel if take is None else self._reel(take)
        at, stage = at_s / reel.scene.dt_s, self._stage
        self._live.pulse.call(lambda: stage.review(reel, at, time.monotonic(), time.time()))
        self._live.refresh()

    def seek(self, at_s: float) -> None:
        """Look at that second of the run."""
        at = at_s / self._stage.scene.dt_s
        self._live.pulse.call(lambda: self._stage.seek(at, time.monotonic()))

    def roll(self, speed: float) -> None:
        """See `Review.roll`."""
        self._live.pulse.call(lambda: self._stage.roll(speed, time.monotonic()))

    def fork(self, others: str | None = None) -> None:
        """Begin a take at the moment that is looked at, or at the present one.

        `others` is as in `LiveStage.demonstrate`.
        """
        self.fork_from(*self._live.pulse.call(self._stage.here), others)

    def fork_from(self, start: Snapshot, origin: Origin, others: str | None) -> None:
        """Begin a take at `start`, which `origin` names."""
        live, stage, scene = self._live, self._stage, self._stage.scene
        live.begin_again()
        crowd = None if others is None else live.actor(others, scene)
        live.need_session()
        live.pulse.call(
            lambda: stage.demonstrate(
                scene, stage.run.seed, time.monotonic(), time.time(), crowd, start, origin
            )
        )
        live.refresh()

    def keep_last(self, seconds: float) -> None:
        """End the running take, or take the last one, and keep its last `seconds` only.

        Raises ConflictError where there is none, InvalidInputError where the take is shorter.
        """
        self._live.stop()
        recorder = self._stage.recorder
        key = None if recorder is None else recorder.last_key
        if recorder is None or key is None:
            raise ConflictError("There is no take to keep the end of. Demonstrate first.")
        written = threading.Event()
        recorder.settle(written.set)
        written.wait(PATIENCE_S)
        keep_last(self._store, self._store.find_take(key).id, seconds, time.time())
        self._live.refresh()

    def _reel(self, take: int) -> Reel:
        """Of a recorded take. Raises NotFoundError, ConflictError for one of another scene."""
        record = self._store.take(take)
        session = self._store.session(record.session)
        scene = make_scene(self._workspace, session.scene, record.options)
        if (session.scene, record.scene_version) != (self._stage.scene.name, scene.version):
            raise ConflictError(
                f"Take {record.number} of {session.name!r} is of scene {session.scene!r} version "
                f"{record.scene_version}; this stage shows {self._stage.scene.name!r} version "
                f"{self._stage.scene.version}."
            )
        return Reel.of_take(scene, record, self._store.load_take(take))
