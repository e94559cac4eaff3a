"""A process with everything loaded that forks studios, so that starting one costs nearly nothing.

It reads a line of JSON for each child and prints one when the child is ready; killing the children
is for whoever asked. They are the studio that `evastudio studio` runs, but for a countdown of a
moment, and a program that cleans, fits and saves without end.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from evastudio.workspace import Workspace

COUNTDOWN_S = 0.1
TOKEN = "a-token-of-the-soak-runs"
SESSION = "To fit"
LEARNERS = ("knn", "local-linear", "svr")
POLICIES = 6


@dataclass
class Child:
    """A process that the nursery forked."""

    pid: int
    url: str = ""
    """Of a studio, without its token."""

    def __post_init__(self) -> None:
        self._watch: int | None = os.pidfd_open(self.pid)

    def end(self, number: signal.Signals, wait_s: float = 30.0) -> float:
        """Send it that signal and return when it is gone; the seconds that took."""
        if self._watch is None:
            return 0.0
        began = time.monotonic()
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._watch, number)
        gone = select.select([self._watch], [], [], wait_s)[0]
        assert gone, f"process {self.pid} is still there {wait_s:g} s after {number.name}"
        os.close(self._watch)
        self._watch = None
        return time.monotonic() - began


class Nursery:
    """The forking process, seen from outside. Threads may share it."""

    def __init__(self, log: Path) -> None:
        """What the children complain of goes to the file `log`."""
        self._log = log.open("ab")
        self._turn = threading.Lock()
        self._children: list[Child] = []

    def __enter__(self) -> Nursery:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.soak.nursery"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        self._told()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        for child in self._children:
            child.end(signal.SIGKILL)
        self._process.communicate()
        self._log.close()

    def studio(self, workspace: Workspace) -> Child:
        """A studio that listens."""
        return self._fork("studio", workspace)

    def saver(self, workspace: Workspace) -> Child:
        """A program that cleans, fits and saves the session SESSION again and again."""
        return self._fork("saver", workspace)

    def _fork(self, what: str, workspace: Workspace) -> Child:
        assert self._process.stdin is not None
        asked = {"what": what, "root": str(workspace.root), "store": workspace.store}
        with self._turn:
            self._process.stdin.write(json.dumps(asked) + "\n")
            self._process.stdin.flush()
            child = Child(**self._told())
            self._children.append(child)
            return child

    def _told(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "what was to be started ended before it was ready"
        return dict(json.loads(line))


def _tell(**told: Any) -> None:
    print(json.dumps(told), flush=True)


def _serve(workspace: Workspace) -> None:
    from evastudio.live import act
    from evastudio.server import serve
    from evastudio.settings import Settings

    act.COUNTDOWN_S = COUNTDOWN_S
    settings = Settings(workspace, port=0, token=TOKEN, browser=False)
    serve(settings, lambda url: _tell(pid=os.getpid(), url=url.partition("/?")[0]))


def _save(workspace: Workspace) -> None:
    from evastudio.errors import StudioError
    from evastudio.live import cleaning, headless

    _tell(pid=os.getpid())
    number = 0
    while True:
        with contextlib.suppress(StudioError):  # the store may be gone for a while
            cleaning.clean(workspace, SESSION, delay="off")
            name = f"policy-{number % POLICIES}"
            learner = LEARNERS[number % len(LEARNERS)]
            headless.fit(workspace, SESSION, learner=learner, delay="off", name=name)
        number += 1


def _warm() -> None:
    """Load what the children need, compiled code too."""
    import evastudio.server
    from evastudio.live import cleaning, headless

    assert evastudio.server
    with tempfile.TemporaryDirectory() as folder:
        place = Workspace(Path(folder))
        headless.record(place, "asteroids", minutes=0.5, session=SESSION)
        cleaning.clean(place, SESSION, delay="off")
        for learner in LEARNERS:
            headless.fit(place, SESSION, learner=learner, delay="off", name="any")


def main() -> None:
    _warm()
    _tell()
    for line in sys.stdin:
        asked = json.loads(line)
        if os.fork() == 0:
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            workspace = Workspace(Path(asked["root"]), asked["store"])
            with Path(os.devnull).open() as nothing:
                os.dup2(nothing.fileno(), 0)
            try:
                (_serve if asked["what"] == "studio" else _save)(workspace)
            finally:
                os._exit(0)


if __name__ == "__main__":
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the killed
    main()
