"""A Dask cluster on this machine: a scheduler and workers, each a process of its own, over TCP.

For `scaling.py` and the tests; nothing here is run by itself.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from distributed import Client

Process = subprocess.Popen[str]


class LocalCluster:
    """A scheduler, and workers that can be started and killed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.processes: list[Process] = []
        scheduler = self._start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        assert scheduler.stderr is not None
        for line in scheduler.stderr:
            found = re.search(r"Scheduler at:\s+(tcp://\S+)", line)
            if found:
                self.address = found[1]
                return
        raise SystemExit("The scheduler ended before it told its address.")

    def work(self, count: int, **environment: str) -> list[Process]:
        """`count` more workers, of one thread each, once they have joined."""
        flags = ("--nthreads", "1", "--no-nanny", "--local-directory", str(self._folder))
        workers = [
            self._start("dask_worker", self.address, *flags, **environment) for _ in range(count)
        ]
        with Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(len(self.processes) - 1, timeout=60)
        return workers

    def close(self) -> None:
        """End every process."""
        for process in self.processes:
            process.kill()
            process.wait()
            if process.stderr is not None:
                process.stderr.close()

    def _start(self, program: str, *arguments: str, **environment: str) -> Process:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *arguments, "--no-dashboard"],
            stderr=subprocess.PIPE if program == "dask_scheduler" else subprocess.DEVNULL,
            text=True,
            env={**os.environ, **environment},
        )
        self.processes.append(process)
        return process
