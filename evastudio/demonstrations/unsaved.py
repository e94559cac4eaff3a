"""Takes that a store could not be given in time: written from their entries, each exactly once."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from evastudio.demonstrations.records import NewTake, Origin
from evastudio.demonstrations.spill_file import (
    ASIDE,
    BEGIN,
    FINISH,
    PAIRS,
    RESTORE,
    SUFFIX,
    TRASH,
    Entry,
    Spilled,
    read_spill,
)
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError, StorageError

logger = logging.getLogger(__name__)

EMPTY_S = 60.0
"""An empty file that is younger is about to be written."""


class Writing:
    """Writes entries into a store. Writing one once more changes nothing.

    A take enters the store with what follows its beginning: without pairs it is nowhere.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._beginnings: dict[str, NewTake] = {}
        self._takes: dict[str, int] = {}

    def write(self, entry: Entry, patient: bool = False) -> None:
        """`patient` as in `Gathering.write`.

        Raises NotFoundError where the take was deleted: then nothing is left to be done.

        Raises ConflictError where its session or its earlier pairs are gone, StorageError, and
        InvalidInputError: then it is still to be kept.
        """
        store, values = self._store, dict(entry.values)
        if entry.kind == BEGIN:
            origin = values.pop("origin")
            values["origin"] = None if origin is None else Origin(**origin)
            self._beginnings[entry.key] = NewTake(key=entry.key, fixed=entry.data, **values)
            return
        take = self._begun(entry.key)
        if entry.kind == PAIRS:
            store.write_pairs(take, values["first_step"], values["steps"], entry.data, patient)
        elif entry.kind == FINISH:
            store.finish_take(take, values["outcome"], values["now"])
        elif entry.kind == TRASH:
            store.trash_take(take, values["now"])
        elif entry.kind == RESTORE:
            store.restore_take(take)

    def _begun(self, key: str) -> int:
        """The id of a take, which is begun in the store where it was not."""
        new = self._beginnings.get(key)
        if new is not None:
            try:
                self._takes[key] = self._store.write_take(new)
            except NotFoundError as error:
                try:
                    self._store.session(new.session)
                except NotFoundError:
                    raise ConflictError(str(error)) from None
                raise
            del self._beginnings[key]
        if key not in self._takes:
            raise NotFoundError("The take that this belongs to is gone.")
        return self._takes[key]


@dataclass(frozen=True)
class Waiting:
    """A file of unsaved takes that nobody writes any more."""

    path: Path
    spilled: Spilled | None
    """None where it is for another store, or cannot be read."""
    problem: str | None = None
    """Why it cannot be taken in, or None."""

    @property
    def pairs(self) -> int:
        entries = self.spilled.entries if self.spilled else ()
        return sum(entry.values["steps"] for entry in entries if entry.kind == PAIRS)

    @property
    def takes(self) -> int:
        entries = self.spilled.entries if self.spilled else ()
        return len({entry.key for entry in entries if entry.kind == PAIRS})


def unsaved(folders: Sequence[Path], identity: str) -> list[Waiting]:
    """The files in `folders` that wait for the store of that identity, in order of time."""
    found = []
    for path in _paths(folders, identity):
        with _alone(path) as ours:
            if ours:
                found.append(_waiting(path, identity))
    return found


def take_in(store: Store, folders: Sequence[Path]) -> list[Waiting]:
    """Write what waits in `folders` into `store`, and be rid of the files; what was written.

    What a killed process had written is not written again. Pairs of takes that were deleted since
    are dropped with them; a take in the trash stays there. A file is kept under another name where
    a take's session or its earlier pairs are gone, because an older store was put back, say.
    Raises StorageError where the store refuses: everything then waits on.
    """
    written = []
    for path in _paths(folders, store.identity):
        with _alone(path) as ours:
            if not ours:
                _forget_empty(path, time.time())
                continue
            found = _waiting(path, store.identity)
            if found.spilled is None:
                continue
            if _write_all(store, found.spilled):
                path.unlink()
            else:
                path.rename(path.with_name(path.name + ASIDE))
                logger.warning("What takes in %s belong to is gone; they are kept there.", path)
            if found.pairs:
                written.append(found)
    for folder in folders:
        with contextlib.suppress(OSError):  # others are in it, or there is none
            folder.rmdir()
    return written


def _write_all(store: Store, spilled: Spilled) -> bool:
    """Whether all of it found its place, or was of takes that were deleted."""
    writing = Writing(store)
    found = True
    for entry in spilled.entries:
        try:
            writing.write(entry)
        except NotFoundError as error:
            logger.warning("%s", error)
        except (ConflictError, InvalidInputError) as error:
            logger.warning("%s", error)
            found = False
    return found


def _paths(folders: Sequence[Path], identity: str) -> list[Path]:
    found = [path for folder in folders for path in folder.glob(f"{identity}-*{SUFFIX}")]
    return sorted(found, key=lambda path: path.name)


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[bool]:
    """Whether nobody else writes the file or takes it in, now and until the block ends."""
    try:
        file = path.open("rb")
    except OSError:  # somebody was faster, or it is not for us
        yield False
        return
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
            return
        yield path.exists() and path.stat().st_size > 0  # an empty one is about to be locked


def _forget_empty(path: Path, now: float) -> None:
    """Delete a file that was made and never written: its process was killed in between."""
    with contextlib.suppress(OSError):  # somebody was faster
        seen = path.stat()
        if seen.st_size == 0 and now - seen.st_mtime > EMPTY_S:
            path.unlink()


def _waiting(path: Path, identity: str) -> Waiting:
    try:
        spilled = read_spill(path)
    except StorageError as error:
        return Waiting(path, None, str(error))
    if spilled.store != identity:
        return Waiting(path, None, f"{str(path)!r} is for another store.")
    return Waiting(path, spilled)
