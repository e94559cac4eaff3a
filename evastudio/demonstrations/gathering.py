"""Writes that many threads ask for at once, in one transaction: each waits for one commit, not all.

Fifty stages that record ask for over a hundred small writes a second, and a database that answers
for what it has taken waits for the disk with each commit.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, Engine

from evastudio.demonstrations.engine import writing
from evastudio.errors import StorageError

Work = Callable[[Connection], None]


@dataclass(eq=False)
class _Asked:
    work: Work
    done: bool = False
    error: BaseException | None = None


class Gathering:
    """Whoever comes while something is written waits, and is written together with the others."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._waiting: list[_Asked] = []
        self._line = threading.Lock()
        self._turn = threading.Lock()

    def write(self, work: Work) -> None:
        """Do `work` in a transaction and return once that is committed; it may be done twice.

        Raises what `work` raises, after which nothing of it is written, and StorageError.
        """
        asked = _Asked(work)
        with self._line:
            self._waiting.append(asked)
        with self._turn:
            if not asked.done:
                with self._line:
                    together, self._waiting = self._waiting, []
                self._write(together)
        if asked.error is not None:
            raise asked.error

    def _write(self, together: Sequence[_Asked]) -> None:
        """All of them or, where one of several cannot be, each on its own."""
        error: BaseException | None = None
        try:
            with writing(self._engine) as connection:
                for asked in together:
                    asked.work(connection)
        except BaseException as raised:
            error = raised
        if error is not None and len(together) > 1 and not isinstance(error, StorageError):
            for asked in together:
                self._write([asked])
            return
        for asked in together:
            asked.done, asked.error = True, error
