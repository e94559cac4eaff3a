"""A program's demonstration: what it does in a headless world becomes takes of a session."""

from __future__ import annotations

import threading
from collections.abc import Callable

from evastudio.demonstrations.names import checked_name
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, StorageError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

PROGRAM = "program:"
"""Begins the name of the pilot of a program's takes; only they can be gone on with over HTTP."""
AHEAD = 1000
"""Pairs that a fast program may be ahead of the store; then it waits."""
WAIT_S = 30.0


class Demonstration:
    """Takes of one session, by the recorder that records people."""

    def __init__(
        self, store: Store, session: SessionRecord, pilot: str, clock: Callable[[], float]
    ) -> None:
        """`pilot` is the program's name; takes say that it is a program's. `clock` gives epoch
        seconds. Raises InvalidInputError for a name that cannot be kept."""
        self.session = session
        self.pilot = checked_name(PROGRAM + pilot, "pilot")
        self._recorder = Recorder(store, session.id)
        self._clock = clock
        self._ahead = 0

    @property
    def running(self) -> bool:
        """Whether a take runs."""
        return self._recorder.running

    @property
    def pairs(self) -> int:
        """Of the running take, or of the last."""
        return self._recorder.pairs

    @property
    def problem(self) -> str | None:
        """Why saving does not work at the moment, or None."""
        return self._recorder.problem

    def begin(self, scene: Scene, snapshot: Snapshot, seed: int) -> None:
        """Begin a take at this moment of one world."""
        self._recorder.begin(scene, snapshot, seed, self.pilot, self._clock())

    def add(self, states: Array, actions: Array, snapshot: Snapshot) -> None:
        """One decision, as `Recorder.add`. Waits where the store is far behind."""
        self._recorder.add(states, actions, snapshot)
        self._ahead += 1
        if self._ahead >= AHEAD:
            written = threading.Event()
            self._recorder.settle(written.set)
            written.wait(WAIT_S)
            self._ahead = 0

    def end(self, outcome: str | None) -> None:
        """End the running take, if any; `outcome` None where it is broken off."""
        self._recorder.end(outcome, self._clock())

    def close(self) -> None:
        """End the running take and return when all is written. Raises StorageError where not."""
        self._recorder.close(self._clock())
        if self.problem is not None:
            raise StorageError(self.problem)


def check_session(session: SessionRecord, scene: Scene) -> None:
    """Raise ConflictError where takes of `scene` do not belong in `session`."""
    if session.scene != scene.name:
        raise ConflictError(
            f"Session {session.name!r} is of scene {session.scene!r}, and this is "
            f"{scene.name!r}. Choose a session of this scene."
        )
    if session.scene_version != scene.version:
        raise ConflictError(
            f"Session {session.name!r} is of version {session.scene_version} of the scene, which "
            f"is now version {scene.version}. Make a new session; the old one can still be fitted."
        )
