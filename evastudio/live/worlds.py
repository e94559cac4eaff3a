"""The headless worlds of a server: opened, found and closed by name."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Mapping, Sequence

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, StorageError, not_found
from evastudio.live.batch import Batch
from evastudio.live.demonstrating import Demonstration, check_session
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot
from evastudio.workspace import Workspace
from evastudio.world.compiled import load
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene

MOST_OPEN = 32
MOST_BYTES = 512 * 2**20
"""That all of them may take in memory."""
IDLE_S = 300.0
"""Worlds that nobody asks for this long are closed; a running take is kept."""
PROGRAM = "program"
"""The name of a program that gives none."""


class Worlds:
    """The batches of headless worlds of a server. Safe to use from several threads."""

    def __init__(
        self, workspace: Workspace, store: Store, clock: Callable[[], float] = time.time
    ) -> None:
        self._workspace = workspace
        self._store = store
        self._clock = clock
        self._batches: dict[str, Batch] = {}
        self._lock = threading.Lock()

    def open(
        self,
        scene: str,
        seeds: Sequence[int],
        *,
        options: Mapping[str, float] | None = None,
        perception: str | None = None,
        session: int | None = None,
        pilot: str = PROGRAM,
    ) -> Batch:
        """New worlds, one for each seed. Raises ConflictError where too many batches are open.

        What is done in the one world becomes takes of `session` where it is given, by `pilot`, the
        program's name.
        """
        made = make_scene(self._workspace, scene, options)
        demonstration = None
        if session is not None:
            record = self._store.session(session)
            check_session(record, made)
            demonstration = Demonstration(self._store, record, pilot, self._clock)
        load()
        try:
            batch = Batch(
                secrets.token_hex(6),
                made,
                seeds,
                pilots=lambda name: self._pilot(name, made),
                perception=perception,
                demonstration=demonstration,
            )
            self._admit(batch)
        except BaseException:
            if demonstration is not None:
                demonstration.close()
            raise
        return batch

    def _pilot(self, name: str, scene: Scene) -> Pilot:
        return load_pilot(self._workspace, name, scene)

    def _admit(self, batch: Batch) -> None:
        with self._lock:
            if len(self._batches) >= MOST_OPEN:
                raise ConflictError(
                    f"{MOST_OPEN} batches of worlds are open already; close one first."
                )
            taken = sum(other.size for other in self._batches.values())
            if taken + batch.size > MOST_BYTES:
                raise ConflictError(
                    "The worlds that are open take all the memory they may; close some first, or "
                    "ask for fewer."
                )
            self._batches[batch.name] = batch

    def get(self, name: str) -> Batch:
        """Raises NotFoundError."""
        with self._lock:
            batch = self._batches.get(name)
        if batch is None:
            raise not_found("batch of worlds", name, [])
        return batch

    def all(self) -> list[Batch]:
        """In the order they were opened."""
        with self._lock:
            return list(self._batches.values())

    def close(self, name: str) -> None:
        """Close a batch; its running take is kept. Raises StorageError where it is not saved."""
        batch = self.get(name)
        with self._lock:
            self._batches.pop(name, None)
        batch.close()

    def close_all(self) -> None:
        """As a server does that ends; what cannot be saved is in the log."""
        for batch in self.all():
            try:
                self.close(batch.name)
            except (LookupError, StorageError):  # closed by another, or told in the log
                continue
