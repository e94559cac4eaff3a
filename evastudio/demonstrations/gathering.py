"""Writes that many threads ask for at once, in one transaction: each waits for one commit, not all.

Fifty stages that record ask for over a hundred small writes a second, and a database that answers
for what it has taken waits for the disk with each commit. Who is patient lets others come.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from sqlalchemy import Connection, Engine

from evastudio.demonstrations.engine import writing
from evastudio.errors import StorageError

T = TypeVar("T")

BETWEEN_S = 0.05
"""From the beginning of one transaction to that of the next, where all who wait are patient."""


@dataclass(eq=False)
class _Asked(Generic[T]):
    what: T
    patient: bool
    done: bool = False
    error: BaseException | None = None
    turn: threading.Event = field(default_factory=threading.Event)
    """Set once it is done, or once its thread is to write what waits by then."""


class Gathering(Generic[T]):
    """Whoever comes while something is written waits, and is written together with the others."""

    def __init__(self, engine: Engine, write: Callable[[Connection, Sequence[T]], None]) -> None:
        """`write` writes several, in a transaction; it raises where one of them cannot be."""
        self._engine = engine
        self._work = write
        self._lock = threading.Lock()
        self._waiting: list[_Asked[T]] = []
        self._busy = False
        self._begun = -math.inf
        self._hurry = threading.Event()

    def write(self, what: T, patient: bool = False) -> None:
        """Write that and return once it is committed. One that is `patient` may wait for others.

        Raises what writing it alone raises, after which nothing of it is written.
        """
        asked = _Asked(what, patient)
        with self._lock:
            self._waiting.append(asked)
            if not patient:
                self._hurry.set()
            waits, self._busy = self._busy, True
        if waits:
            asked.turn.wait()
        if not asked.done:
            self._write_waiting()
        if asked.error is not None:
            raise asked.error

    def _write_waiting(self) -> None:
        self._let_come()
        with self._lock:
            together, self._waiting = self._waiting, []
        self._write(together)
        with self._lock:
            following = self._waiting[:1]
            self._busy = bool(following)
        for asked in (*following, *together):
            asked.turn.set()

    def _let_come(self) -> None:
        """Return when the next transaction may begin."""
        with self._lock:
            if all(asked.patient for asked in self._waiting):
                self._hurry.clear()
        self._hurry.wait(max(0.0, self._begun + BETWEEN_S - time.monotonic()))
        self._begun = time.monotonic()

    def _write(self, together: Sequence[_Asked[T]]) -> None:
        """All of them or, where one of several cannot be, each on its own."""
        error: BaseException | None = None
        try:
            with writing(self._engine) as connection:
                self._work(connection, [asked.what for asked in together])
        except BaseException as raised:
            error = raised
        if error is not None and len(together) > 1 and not isinstance(error, StorageError):
            for asked in together:
                self._write([asked])
            return
        for asked in together:
            asked.done, asked.error = True, error
