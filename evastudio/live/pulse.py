"""A thread that does what is due in time, and in between what others ask of it."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from typing import TypeVar

from evastudio.errors import ConflictError

T = TypeVar("T")

PATIENCE_S = 30.0
"""What is asked of it is done within this time, or has failed."""


class Pulse:
    """Beats when it is due, and after every call."""

    def __init__(
        self,
        name: str,
        beat: Callable[[bool], float],
        failed: Callable[[Exception], None],
    ) -> None:
        """`beat` is told whether somebody called before, and says when to beat again.

        Its times are of the monotonic clock, and it must not raise. `failed` hears what a call
        raised that nobody waits for.
        """
        self._beat = beat
        self._failed = failed
        self._calls: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        """What is asked of it; None is the last."""
        self._lock = threading.Lock()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Beat from now on."""
        self._thread.start()

    def post(self, work: Callable[[], None]) -> None:
        """Do `work` on the thread soon; does not wait. Raises ConflictError once it is closed."""
        with self._lock:
            if self._closing:
                raise ConflictError("This stage is closed; open another.")
            self._calls.put(work)

    def call(self, work: Callable[[], T]) -> T:
        """Do `work` on the thread and return what it returns, or raise what it raises."""
        if threading.current_thread() is self._thread:
            return work()
        future: Future[T] = Future()

        def run() -> None:
            try:
                future.set_result(work())
            except BaseException as error:
                future.set_exception(error)

        self.post(run)
        return future.result(timeout=PATIENCE_S)

    def close(self) -> None:
        """Do what was asked so far, and end."""
        with self._lock:
            self._closing = True
            self._calls.put(None)
        self._thread.join()

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            calls = self._asked(due)
            for call in calls:
                if call is None:
                    return
                try:
                    call()
                except Exception as error:
                    self._failed(error)
            due = self._beat(bool(calls))

    def _asked(self, due: float) -> list[Callable[[], None] | None]:
        """All that is asked by the time somebody asks, or by `due`."""
        found: list[Callable[[], None] | None] = []
        with contextlib.suppress(Empty):
            left = due - time.monotonic()
            if left > 0.0:
                found.append(self._calls.get(timeout=left))
            while True:
                found.append(self._calls.get_nowait())
        return found
