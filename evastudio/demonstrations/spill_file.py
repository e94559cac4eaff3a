"""A file of what waits to be written into a store: appended while takes run, read after a crash.

It is a row of frames, each with its length and CRC-32 (little endian), so that an end torn by a
full disk or a killed process is seen and left out. The first frame says which store it is for.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
import struct
import zlib
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evastudio.errors import StorageError

FORMAT = 1
SUFFIX = ".unsaved"
ASIDE = ".kept"
"""Added to the name of a file that cannot be taken in."""
FRAME = struct.Struct("<II")
DONE_BYTES = 256_000
"""So much that is done with may stay in a file: shortening it can take a busy disk a while."""
HELD_BYTES = 2**15
"""So much is kept in memory too, which is a chunk or some: mostly they are done with at once."""
MOST_BYTES = 2**30
"""Of one frame; a longer one is damage."""

BEGIN, PAIRS, FINISH, TRASH, RESTORE = "begin", "pairs", "finish", "trash", "restore"


@dataclass(frozen=True)
class Entry:
    """One thing to write into the store."""

    kind: str
    key: str
    """Of the take; it tells it from every other, also before the store has given it an id."""
    values: Mapping[str, Any]
    data: bytes = b""
    """Packed arrays: the fixed ones of a take that begins, or its next pairs."""

    def to_bytes(self) -> bytes:
        head = json.dumps({"kind": self.kind, "key": self.key, "values": dict(self.values)})
        return head.encode() + b"\n" + self.data


class SpillFile:
    """A file of entries that only this process uses, and of which the first are done with."""

    def __init__(self, folder: Path, identity: str, number: int) -> None:
        """A new file in `folder` for the store of that identity; later numbers go on after it.

        Raises OSError where none can be written there.
        """
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self.path = folder / f"{identity}-{number:06d}-{secrets.token_hex(4)}{SUFFIX}"
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        self.keys: set[str] = set()
        """Of the takes whose beginning it holds."""
        self.end = 0
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX)
            header = {"format": FORMAT, "store": identity}
            self._append(json.dumps(header).encode())
        except OSError:
            self.remove()
            raise
        self._first = self._again = self._at = self.end
        self._held: deque[tuple[int, Entry]] = deque()
        """The first entries that are not done with, and where each of them ends."""
        self._held_bytes = 0
        self._once = False
        """Whether it holds what is better not done once more: ends, throws into the trash."""

    def append(self, entry: Entry) -> None:
        """Raises OSError, and leaves the file as it was, where it cannot be written."""
        begins, waits = self.end, self.waits
        leads = begins == self._first
        self._once |= entry.kind not in (BEGIN, PAIRS)
        self._append(entry.to_bytes())
        next_to = self._held[-1][0] == begins if self._held else not waits
        if next_to and self._held_bytes + len(entry.data) <= HELD_BYTES:
            self._held.append((self.end, entry))
            self._held_bytes += len(entry.data)
        if entry.kind == BEGIN:
            self.keys.add(entry.key)
            if leads:
                self._again = self.end

    def _append(self, payload: bytes) -> None:
        frame = FRAME.pack(len(payload), zlib.crc32(payload)) + payload
        try:
            done = 0
            while done < len(frame):
                done += os.pwrite(self._file, frame[done:], self.end + done)
        except OSError:
            os.ftruncate(self._file, self.end)
            raise
        self.end += len(frame)

    def sync(self) -> None:
        """Return when all of it is on the disk."""
        os.fsync(self._file)

    @property
    def waits(self) -> bool:
        """Whether an entry is not done with."""
        return self._at < self.end

    def front(self) -> Entry | None:
        """The first entry that is not done with."""
        if not self.waits:
            return None
        if self._held:
            return self._held[0][1]
        length, _ = FRAME.unpack(os.pread(self._file, FRAME.size, self._at))
        return _entry(os.pread(self._file, length, self._at + FRAME.size))

    def done(self) -> None:
        """The first entry is in the store. A file without any other begins anew.

        The beginning of a take stays there as long as that goes on: it is the largest entry.
        """
        if self._held:
            self._at, entry = self._held.popleft()
            self._held_bytes -= len(entry.data)
        else:
            length, _ = FRAME.unpack(os.pread(self._file, FRAME.size, self._at))
            self._at += FRAME.size + length
        if self._at == self.end and (self._once or self.end > DONE_BYTES):
            self._once = False
            if len(self.keys) > 1:
                self.keys.clear()
                self._again = self._first
            os.ftruncate(self._file, self._again)
            self._at = self.end = self._again

    def close(self) -> None:
        os.close(self._file)

    def remove(self) -> None:
        self.path.unlink(missing_ok=True)
        self.close()


@dataclass(frozen=True)
class Spilled:
    """What a file of an ended process holds."""

    path: Path
    store: str
    """Identity of the store it is for."""
    entries: tuple[Entry, ...]
    torn: int
    """Bytes at its end that belong to no whole entry."""


def read_spill(path: Path) -> Spilled:
    """The whole entries in `path`. Raises StorageError where it is no such file."""
    frames = _frames(path)
    try:
        header, end = next(frames)
        told = json.loads(header)
        identity, version = str(told["store"]), told["format"]
    except OSError as error:
        raise StorageError(f"{str(path)!r} cannot be read ({error.strerror}).") from None
    except (StopIteration, ValueError, KeyError, TypeError):
        raise StorageError(f"{str(path)!r} does not hold unsaved takes, or is damaged.") from None
    if version != FORMAT:
        raise StorageError(
            f"{str(path)!r} has format {version!r}, and this studio reads {FORMAT}. Install a "
            "newer EVA Studio to take it in."
        )
    entries = []
    for payload, after in frames:
        try:
            entries.append(_entry(payload))
        except (ValueError, KeyError, TypeError):
            break
        end = after
    return Spilled(path, identity, tuple(entries), path.stat().st_size - end)


def _frames(path: Path) -> Iterator[tuple[bytes, int]]:
    """Every whole frame from the beginning on, and where it ends."""
    with path.open("rb") as file:
        end = 0
        while len(head := file.read(FRAME.size)) == FRAME.size:
            length, checksum = FRAME.unpack(head)
            if length > MOST_BYTES:
                return
            payload = file.read(length)
            if len(payload) < length or zlib.crc32(payload) != checksum:
                return
            end += FRAME.size + length
            yield payload, end


def _entry(payload: bytes) -> Entry:
    head, _, data = payload.partition(b"\n")
    told = json.loads(head)
    return Entry(str(told["kind"]), str(told["key"]), dict(told["values"]), data)
