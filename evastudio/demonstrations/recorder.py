"""The recorder: streams the pairs of a running take to the store, never making it wait.

Two threads serve it. One puts what was recorded into a spill, which outlives the process; the
other writes from there into the store, as long as that takes, and tries again where it fails.
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.running import Row, Running, packed_rows
from evastudio.demonstrations.spill import Spill
from evastudio.demonstrations.spill_file import FINISH, PAIRS, RESTORE, TRASH, Entry
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.unsaved import Writing
from evastudio.errors import NotFoundError, StudioError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

logger = logging.getLogger(__name__)

CHUNK_S = 0.3
"""Longest time that pairs wait in memory; with the write itself it stays under 0.5 s."""
CLOSE_S = 10.0
"""So long a closing recorder goes on trying to write what it could not."""
RETRY_S = 0.25
FEW = 3
"""While no more chunks wait, they are written together with those of other recorders."""


class Recorder:
    """Writes takes into one session, on threads of its own.

    A take enters the store with its first chunk. What the store does not take waits in a file, or
    in memory where none can be written; `problem` says so meanwhile.
    """

    def __init__(
        self,
        store: Store,
        session: int,
        perception: str | None = None,
        folders: Sequence[Path] = (),
    ) -> None:
        """What waits is kept in the first of `folders` that can be written."""
        self.session = session
        self._perception = perception
        self._spill = Spill(store.identity, folders)
        self._writing = Writing(store)
        self._keeper = ThreadPoolExecutor(max_workers=1, thread_name_prefix="recorder")
        self._writer = threading.Thread(target=self._write_on, name="writer", daemon=True)
        self._wake = threading.Condition()
        self._due = False
        self._closing_at: float | None = None
        self._calls: list[Callable[[], None]] = []
        self._kept = self._written = 0
        self._take: Running | None = None
        self._last: Running | None = None
        self._thrown: Running | None = None
        self._failure: str | None = None
        self._broken_off: str | None = None
        self.left: list[Path] = []
        """Files that still held something when it was closed."""

    @property
    def problem(self) -> str | None:
        """Why the latest write failed, and where what was recorded is meanwhile, or None."""
        failure = self._failure
        if failure is None:
            return self._broken_off
        place = self._spill.place
        where = "in memory" if place is None else f"in the file {str(place)!r}"
        return f"Recording goes on {where} until it can be saved. Saving failed: {failure}"

    @property
    def backlog(self) -> int:
        """How many chunks wait to be written."""
        return self._kept - self._written

    @property
    def running(self) -> bool:
        return self._take is not None

    @property
    def pairs(self) -> int:
        """Pairs of the running take, or else of the last one."""
        take = self._take or self._last
        return take.pairs if take else 0

    @property
    def last_key(self) -> str | None:
        """The key of the take that ended last; None where there is none."""
        return None if self._last is None else self._last.key

    @property
    def running_key(self) -> str | None:
        """The key of the running take; None where there is none."""
        return None if self._take is None else self._take.key

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
        self._broken_off = None
        self._take = Running(scene, self.session, seed, pilot, name, snapshot, now, origin)

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
        """Hand what is in memory to the keeping thread now."""
        take = self._take
        if take is not None and take.buffer:
            rows, take.buffer = take.buffer, []
            self._keeper.submit(self._keep_pairs, take, rows)

    def end(self, outcome: str | None, now: float) -> None:
        """End the running take, if any; `outcome` None where it was broken off."""
        take = self._take
        if take is None:
            return
        self.flush()
        self._take, self._last, self._thrown = None, take, None
        self._keeper.submit(self._keep, take, FINISH, {"outcome": outcome, "now": now})

    def discard(self, now: float) -> bool:
        """Throw the running take, or else the last one, into the trash; False if there is none."""
        self.end(None, now)
        take, self._last = self._last, None
        if take is None:
            return False
        self._thrown = take
        self._keeper.submit(self._keep, take, TRASH, {"now": now})
        return True

    def undo(self) -> bool:
        """Bring back the take that `discard` threw away last; False if there is none."""
        take, self._thrown = self._thrown, None
        if take is None:
            return False
        self._last = take
        self._keeper.submit(self._keep, take, RESTORE, {})
        return True

    def settle(self, then: Callable[[], None]) -> None:
        """Call `then` on the writing thread after everything asked for so far.

        What could not be written is tried again first. A closed recorder calls nobody.
        """

        def told() -> None:
            with self._wake:
                self._calls.append(then)
            self._write_now()

        with contextlib.suppress(RuntimeError):  # closed by another thread
            self._keeper.submit(told)

    def close(self, now: float, patience_s: float = CLOSE_S) -> None:
        """End the running take and return when everything is written.

        A store that refuses is asked again for `patience_s`; `problem` then says what is missing,
        and `left` where it waits to be taken in (`evastudio.demonstrations.unsaved`).
        """
        with contextlib.suppress(RuntimeError):  # closed already
            self.end(None, now)
        self._keeper.shutdown(wait=True)
        until = time.monotonic() + patience_s
        with self._wake:
            self._closing_at = until
            self._wake.notify()
        if self._writer.ident is not None:
            self._writer.join(max(0.0, until - time.monotonic()) + RETRY_S)
        left, lost = self._spill.close()
        self.left += left
        if lost:
            logger.error("A take of session %d is not whole. %s", self.session, self.problem)
        for path in left:
            logger.warning("A take of session %d waits in %s to be saved.", self.session, path)

    # -- the keeping thread --------------------------------------------------------------------

    def _keep_pairs(self, take: Running, rows: list[Row]) -> None:
        if take.broken:
            return
        try:
            if take.begin is None:
                take.begin = take.beginning()
            packed = packed_rows(rows)
        except Exception as error:  # scenes are other people's code
            logger.warning("Pairs could not be packed", exc_info=error)
            take.broken = True
            self._broken_off = f"The take ends here, its pairs cannot be written: {error}"
            return
        self._keep(take, PAIRS, {"first_step": take.kept, "steps": len(rows)}, packed)
        take.kept += len(rows)

    def _keep(self, take: Running, kind: str, values: dict[str, Any], data: bytes = b"") -> None:
        if take.begin is None:
            return  # of a take without pairs there is no trace
        if kind == PAIRS and take.kept == 0:
            self._spill.put(take.begin, take.begin)
        if self._spill.put(Entry(kind, take.key, values, data), take.begin):
            self._kept += kind == PAIRS
        else:
            take.broken = kind == PAIRS
            self._broken_off = "The take ends here: there is no room for it on any disk."
        self._write_now()

    def _write_now(self) -> None:
        with self._wake:
            if self._writer.ident is None:
                self._writer.start()
            self._due = True
            self._wake.notify()

    # -- the writing thread --------------------------------------------------------------------

    def _write_on(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(self._asked, None if self._failure is None else RETRY_S)
                self._due = False
                calls, self._calls = self._calls, []
                closing_at = self._closing_at
            self._write()
            for call in calls:
                try:
                    call()
                except Exception as error:
                    logger.warning("The store could not be read: %s", error)
            if closing_at is not None:
                if self._failure is None or time.monotonic() >= closing_at:
                    return
                time.sleep(RETRY_S)

    def _asked(self) -> bool:
        return self._due or self._closing_at is not None

    def _write(self) -> None:
        """Write what is in line until nothing is, or the store refuses."""
        while (entry := self._spill.front()) is not None:
            try:
                self._writing.write(entry, patient=self.backlog <= FEW)
            except NotFoundError as error:  # the take was deleted meanwhile: nothing to try again
                logger.warning("%s", error)
            except Exception as error:  # whatever it is, the person must be told
                if self._failure is None:
                    seen = None if isinstance(error, StudioError) else error
                    logger.warning("A take could not be written: %s", error, exc_info=seen)
                self._failure = _reason(error)
                self._spill.sync()
                return
            self._spill.done()
            self._written += entry.kind == PAIRS
        self._failure = None


def _reason(error: Exception) -> str:
    """Why a store refuses, in the words of its database where it has any."""
    return " ".join(str(error.__cause__ or error).split()).rstrip(".") + "."
