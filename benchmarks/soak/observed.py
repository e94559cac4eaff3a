"""A studio that runs, and what its own metrics say of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx

from benchmarks.soak.pages import Stage
from evastudio.studio.mounted import SUBPROTOCOL
from evastudio.workspace import Workspace

CORES = 2
SETTLE_S = 30.0


@dataclass(frozen=True)
class Sample:
    """How a studio stands."""

    cpu_s: float
    """CPU time used since its start."""
    memory_mb: float
    """Resident."""
    steps: float
    late_steps: float
    late_200ms: float
    """Decisions that began over 200 ms late."""
    waiting: float
    """Chunks of takes not yet in the store."""
    all_cpu_s: float
    """CPU time used on this machine by everybody."""

    def late_since(self, before: Sample) -> float:
        """Share of the decisions since then that began over half a step late."""
        return (self.late_steps - before.late_steps) / max(self.steps - before.steps, 1.0)

    def very_late_since(self, before: Sample) -> float:
        """Share of the decisions since then that began over 200 ms late."""
        return (self.late_200ms - before.late_200ms) / max(self.steps - before.steps, 1.0)


@dataclass(frozen=True)
class Observed:
    """A studio in a process of its own, held to two cores."""

    base: str
    token: str
    workspace: Workspace
    client: httpx.Client

    @property
    def front_door(self) -> str:
        """Where a browser opens it."""
        return f"{self.base}/?token={self.token}"

    def sample(self) -> Sample:
        lines = self.client.get("/metrics").text.splitlines()
        told = {
            name: float(value)
            for name, _, value in (line.rpartition(" ") for line in lines if line[:1] != "#")
        }
        lateness = "evastudio_step_lateness_seconds"
        quick = told[f'{lateness}_bucket{{le="0.2"}}']
        return Sample(
            told["process_cpu_seconds_total"],
            told["process_resident_memory_bytes"] / 1e6,
            told["evastudio_steps_total"],
            told["evastudio_late_steps_total"],
            told[f"{lateness}_count"] - quick,
            told['evastudio_queue_length{queue="recorder"}'],
            _busy_s(),
        )

    def open(self, seed: int, name: str, watched: bool) -> tuple[int, Stage]:
        """A session and a stage that records into it."""
        body = {"scene": "asteroids", "name": name, "demonstrator": "random keys"}
        session = self._post("/api/v1/sessions", body)["id"]
        asked = {
            "scene": "asteroids",
            "options": {"density": 0.1, "half_width": 150.0},
            "session": session,
            "seed": seed,
        }
        stage = self._post("/api/v1/stages", asked)
        at = self.base.replace("http", "ws")
        view = at + stage["view"] if watched else None
        return session, Stage(at + stage["socket"], view, SUBPROTOCOL)

    def kept(self, session: int) -> list[int]:
        """Pairs of each take of a session in the store, in order, once nothing waits any more."""
        until = time.monotonic() + SETTLE_S
        while self.sample().waiting and time.monotonic() < until:
            time.sleep(0.1)
        pairs: list[int] = []
        query: dict[str, str] = {}
        while True:
            answer = self.client.get(f"/api/v1/sessions/{session}/takes", params=query)
            page = answer.raise_for_status().json()
            pairs += [take["pairs"] for take in page["items"]]
            if not page.get("next"):
                return pairs
            query["cursor"] = str(page["next"])

    def _post(self, path: str, body: object) -> dict[str, object]:
        answer = self.client.post(path, json=body)
        answer.raise_for_status()
        found: dict[str, object] = answer.json()
        return found


@contextmanager
def observed(folder: Path) -> Iterator[Observed]:
    """A studio on an empty workspace in `folder`, stopped at the end."""
    workspace = Workspace(folder / "work")
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser"),
            *("--json", "--workspace", str(workspace.root)),
        ],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        os.sched_setaffinity(process.pid, sorted(os.sched_getaffinity(0))[:CORES])
        assert process.stdout is not None
        base, _, token = json.loads(process.stdout.readline())["url"].partition("/?token=")
        bearer = {"Authorization": f"Bearer {token}"}
        with httpx.Client(base_url=base, headers=bearer, timeout=60, trust_env=False) as client:
            yield Observed(base, token, workspace, client)
    finally:
        process.terminate()
        process.wait(60)
        if process.stdout is not None:
            process.stdout.close()


def _busy_s() -> float:
    """CPU time that this machine has spent on anything since it started (Linux)."""
    numbers = [int(part) for part in Path("/proc/stat").read_text().split("\n")[0].split()[1:]]
    idle = numbers[3] + numbers[4]
    return (sum(numbers[:8]) - idle) / os.sysconf("SC_CLK_TCK")
