"""The recorder: streams the pairs of a running take to the store, never making it wait."""

from __future__ import annotations

import contextlib
import logging
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

logger = logging.getLogger(__name__)

CHUNK_S = 0.4
"""Longest time that pairs wait in memory; with the write itself it stays under 0.5 s."""
CLOSE_S = 10.0
"""So long a closing recorder goes on trying to write what it could not."""
RETRY_S = 0.1

Row = tuple[Array, Array, Snapshot]
"""State (1, n), action (1, m), or those of all characters (1, characters, m), and moment of one
decision step."""


@dataclass
class _Running:
    """A take in the making. Only the writing thread touches `id` and `written`."""

    scene: Scene
    seed: int
    pilot: str
    perception: str
    snapshot: Snapshot
    started_at: float
    origin: Origin | None = None
    pairs: int = 0
    buffer: list[Row] = field(default_factory=list)
    written: int = 0
    id: int | None = None


class Recorder:
    """Writes takes into one session, on a thread of its own.

    A take enters the store with its first chunk. A write that fails is kept and tried again
    with the next one; `problem` says so meanwhile.
    """

    def __init__(self, store: Store, session: int, perception: str | None = None) -> None:
        self._store = store
        self.session = session
        self._perception = perception
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="recorder")
        self._take: _Running | None = None
        self._last: _Running | None = None
        self._thrown: _Running | None = None
        self._pending: deque[Callable[[], None]] = deque()
        self.problem: str | None = None
        """Why the latest write failed, or None."""

    @property
    def running(self) -> bool:
        return self._take is not None

    @property
    def pairs(self) -> int:
        """Pairs of the running take, or else of the last one."""
        take = self._take or self._last
        return take.pairs if take else 0

    @property
    def last_take(self) -> int | None:
        """Id of the take that ended last, once it is written; None where there is none."""
        return None if self._last is None else self._last.id

    @property
    def can_discard(self) -> bool:
        return self._take is not None or self._last is not None

    @property
    def can_undo(self) -> bool:
        return self._thrown is not None

    def begin(
        self,
        scene: Scene,
        snapshot: Snapshot,
        seed: int,
        pilot: str,
        now: float,
        origin: Origin | None = None,
    ) -> None:
        """Start a take in the world of `snapshot`. A running one is ended as it is.

        One that goes on from a moment of another run has that as its `origin`.
        """
        self.end(None, now)
        name = scene.perception(self._perception).name
        self._take = _Running(scene, seed, pilot, name, snapshot, now, origin)

    def add(self, state: Array, action: Array, snapshot: Snapshot) -> None:
        """One pair and the moment it belongs to: rows of shape (1, n) and (1, m).

        Of many characters the state is the lead's, and the actions are those of all.
        """
        take = self._take
        if take is None:
            return
        take.pairs += 1
        take.buffer.append((state, action, snapshot))
        if len(take.buffer) >= max(1, int(CHUNK_S / take.scene.dt_s)):
            self.flush()

    def flush(self) -> None:
        """Hand what is in memory to the writer now."""
        take = self._take
        if take is not None and take.buffer:
            rows, take.buffer = take.buffer, []

            self._submit(lambda: self._write(take, rows))

    def end(self, outcome: str | None, now: float) -> None:
        """End the running take, if any; `outcome` None where it was broken off."""
        take = self._take
        if take is None:
            return
        self.flush()
        self._take, self._last, self._thrown = None, take, None

        def finish() -> None:
            if take.id is not None:
                self._store.finish_take(take.id, outcome, now)

        self._submit(finish)

    def discard(self, now: float) -> bool:
        """Throw the running take, or else the last one, into the trash; False if there is none."""
        self.end(None, now)
        take, self._last = self._last, None
        if take is None:
            return False
        self._thrown = take

        def trash() -> None:
            if take.id is not None:
                self._store.trash_take(take.id, now)

        self._submit(trash)
        return True

    def undo(self) -> bool:
        """Bring back the take that `discard` threw away last; False if there is none."""
        take, self._thrown = self._thrown, None
        if take is None:
            return False
        self._last = take

        def restore() -> None:
            if take.id is not None:
                self._store.restore_take(take.id)

        self._submit(restore)
        return True

    def settle(self, then: Callable[[], None]) -> None:
        """Call `then` on the writing thread after everything asked for so far.

        What could not be written is tried again first. A closed recorder calls nobody.
        """

        def told() -> None:
            self._retry()
            try:
                then()
            except Exception as error:
                logger.warning("The store could not be read: %s", error)

        with contextlib.suppress(RuntimeError):  # closed by another thread
            self._writer.submit(told)

    def close(self, now: float, patience_s: float = CLOSE_S) -> None:
        """End the running take and return when everything is written.

        A store that refuses is asked again for `patience_s`; `problem` then says what is missing.
        """
        self.end(None, now)
        with contextlib.suppress(RuntimeError):  # closed already
            self._writer.submit(self._insist, patience_s)
        self._writer.shutdown(wait=True)
        if self._pending:
            logger.error("A take of session %d is not whole. %s", self.session, self.problem)

    def _submit(self, work: Callable[[], None]) -> None:
        self._writer.submit(self._drain, work)

    def _drain(self, work: Callable[[], None]) -> None:
        """Do `work` after what failed before; what fails now stays first in line."""
        self._pending.append(work)
        self._retry()

    def _insist(self, patience_s: float) -> None:
        until = time.monotonic() + patience_s
        while self._pending and time.monotonic() < until:
            time.sleep(RETRY_S)
            self._retry()

    def _retry(self) -> None:
        while self._pending:
            try:
                self._pending[0]()
            except NotFoundError as error:  # the take was deleted meanwhile: nothing to try again
                logger.warning("%s", error)
            except Exception as error:  # whatever it is, the person must be told
                if self.problem is None:
                    logger.warning("A take could not be written", exc_info=error)
                self.problem = f"Recording goes on in memory, saving failed: {error}"
                return
            self._pending.popleft()
        self.problem = None

    def _write(self, take: _Running, rows: list[Row]) -> None:
        if take.id is None:
            take.id = self._store.begin_take(
                self.session,
                take.scene,
                take.perception,
                take.seed,
                take.pilot,
                take.snapshot.fixed,
                take.started_at,
                take.origin,
            )
        moving: dict[str, AnyArray] = {
            name: np.concatenate([snapshot.moving[name] for _, _, snapshot in rows])
            for name in rows[0][2].moving
        }
        self._store.append(
            take.id,
            take.written,
            np.concatenate([state for state, _, _ in rows]),
            np.concatenate([action for _, action, _ in rows]),
            moving,
        )
        take.written += len(rows)
