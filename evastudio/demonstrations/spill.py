"""A spill: a line of what waits for a store, in files where any can be written, else in memory."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Sequence
from pathlib import Path

from evastudio.demonstrations.spill_file import Entry, SpillFile

FILE_BYTES = 64_000_000
"""A longer file is followed by another, so that a long line gives back what is done with."""

MEMORY_BYTES = 256_000_000
"""Of arrays that wait where no file can be written."""


class Spill:
    """Entries in order. One thread may put them in while another takes them out."""

    def __init__(self, identity: str, folders: Sequence[Path]) -> None:
        """For the store of that identity; of `folders` the first that can be written is used."""
        self._identity = identity
        self._folders = folders
        self._lock = threading.Lock()
        self._files: deque[SpillFile] = deque()
        self._memory: deque[tuple[Entry, Entry]] = deque()
        self._number = 0
        self._closed = False
        self.place: Path | None = None
        """The file that the latest entry went to; None where it is in memory."""

    def put(self, entry: Entry, begin: Entry) -> bool:
        """Whether there is room for it.

        `begin` is the beginning of its take: every file holds it before the take's pairs.
        """
        with self._lock:
            if sum(len(waiting.data) for waiting, _ in self._memory) > MEMORY_BYTES:
                return False
            self._memory.append((entry, begin))
            while self._memory and self._keep(*self._memory[0]):
                self._memory.popleft()
            self.place = None if self._memory else self._files[-1].path
            return True

    def _keep(self, entry: Entry, begin: Entry) -> bool:
        """Put `entry` into a file; whether any can be written."""
        if self._files and self._files[-1].end < FILE_BYTES:
            with contextlib.suppress(OSError):
                _append(self._files[-1], entry, begin)
                return True
        for folder in self._folders:
            try:
                file = SpillFile(folder, self._identity, self._number)
            except OSError:
                continue
            try:
                _append(file, entry, begin)
            except OSError:
                file.remove()
                continue
            self._number += 1
            self._files.append(file)
            return True
        return False

    def sync(self) -> None:
        """Return when what is in files is on the disk; for the thread that takes entries out.

        A disk may be slow: meanwhile others are put in.
        """
        with self._lock:
            files = list(self._files)
        with contextlib.suppress(OSError):
            for file in files:
                file.sync()

    def front(self) -> Entry | None:
        """The first in line; None where nothing waits."""
        with self._lock:
            for file in self._files:
                if (entry := file.front()) is not None:
                    return entry
            return self._memory[0][0] if self._memory and not self._closed else None

    def done(self) -> None:
        """The first in line is in the store."""
        with self._lock:
            for file in list(self._files):
                if file.waits:
                    file.done()
                    return
                if file is not self._files[-1]:
                    file.remove()
                    self._files.remove(file)
            if self._memory:
                self._memory.popleft()

    def close(self) -> tuple[list[Path], int]:
        """The files that still hold entries, now left to whoever takes them in, and how many
        entries are in memory alone. Nothing comes to the front any more."""
        with self._lock:
            left = []
            self._closed = True
            for file in self._files:
                if not file.waits:
                    file.remove()
                else:
                    with contextlib.suppress(OSError):
                        file.sync()
                    file.close()
                    left.append(file.path)
            self._files.clear()
            for folder in self._folders:
                with contextlib.suppress(OSError):  # others are in it
                    folder.rmdir()
            return left, len(self._memory)


def _append(file: SpillFile, entry: Entry, begin: Entry) -> None:
    if begin.key not in file.keys and entry is not begin:
        file.append(begin)
    file.append(entry)
