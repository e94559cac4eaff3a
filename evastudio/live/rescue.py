"""The rescue of takes that wait in files to be saved: at the start, and after a store refused."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from pathlib import Path

from evastudio.demonstrations.store import Store
from evastudio.demonstrations.unsaved import take_in
from evastudio.errors import StorageError

logger = logging.getLogger(__name__)

RETRY_S = 2.0


class Rescue:
    """Takes in what waits, on a thread of its own that ends when nothing does."""

    def __init__(self, store: Store, folders: Sequence[Path]) -> None:
        self._store = store
        self._folders = folders
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._again = False
        self._closing = threading.Event()

    def begin(self) -> None:
        """Look for what waits, and go on until all of it is in the store; does not wait."""
        with self._lock:
            self._again = True
            if self._thread is None and not self._closing.is_set():
                self._thread = threading.Thread(target=self._run, name="rescue", daemon=True)
                self._thread.start()

    def wait(self, patience_s: float = 2.0) -> None:
        """Return when nothing waits any more, or after that time."""
        thread = self._thread
        if thread is not None:
            thread.join(patience_s)

    def close(self) -> None:
        """Stop; what still waits is taken in at the next start."""
        self._closing.set()
        self.wait(0.5)

    def _run(self) -> None:
        while not self._closing.is_set():
            with self._lock:
                if not self._again:
                    self._thread = None
                    return
                self._again = False
            try:
                for found in take_in(self._store, self._folders):
                    logger.warning(
                        "%d pairs of %d takes that were not known to be saved are saved now.",
                        found.pairs,
                        found.takes,
                    )
            except StorageError as error:
                logger.info("Takes still wait to be saved: %s", error)
                self._again = True
                self._closing.wait(RETRY_S)
            except Exception:  # a file that nobody foresaw is no reason to end the studio
                logger.exception("Takes that wait could not be saved")
