"""Requests generated from the API's own description, against a studio that runs.

schemathesis makes them, valid and invalid, and checks every answer against the description: no
failure of the server, no status, type, header or body that is not told of, nothing invalid taken
in, nothing valid refused, nothing without a token, no method that does not belong. As an author
and again as a viewer, for whom the studio must be afterwards as it was before.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import httpx

from benchmarks.report import ROOT, commit, where_and_when, write_section

API = "/api/v1"
CASES = 10_000
"""At least, as each of both."""
EXAMPLES = 110
"""For each operation, beside those that cover every bound of its parameters."""
HOOKS = "benchmarks.soak.npz_bodies"
TIDY_S = 0.5
"""Between looks for jobs that generated requests began, which would run for hours, and stages."""
STAGES = 4
"""Of those that are open so many are left so."""
SETTINGS = """
request-timeout = 30.0
suppress-health-check = ["all"]
[generation]
no-shrink = true
database = "none"
# What a description cannot tell is refused as 422: the width of a policy's state, the name of a
# scene's option, text that is nothing but blanks, and so on.
[checks.positive_data_acceptance]
expected-statuses = ["2xx", "3xx", "401", "403", "404", "409", "412", "413", "422", "429"]
[checks.negative_data_rejection]
expected-statuses = [
  "401", "403", "404", "405", "406", "409", "412", "413", "414", "415", "422", "429"
]
# Streams without end; tests/api/test_job_feed.py follows them.
[[operations]]
include-path-regex = "/events$"
enabled = false
"""


@dataclass(frozen=True)
class Found:
    """What a run came to."""

    cases: int
    failures: tuple[str, ...]
    """As schemathesis tells them, each with the request that shows it."""
    seconds: float


@dataclass(frozen=True)
class Running:
    """A studio in a process of its own."""

    base: str
    token: str
    workspace: Path

    def viewer(self) -> str:
        """A viewer's token."""
        told = subprocess.run(
            [
                *(sys.executable, "-m", "evastudio", "tokens", "add", "Viewer"),
                *("--role", "viewer", "--workspace", str(self.workspace), "--json"),
            ],
            check=True,
            capture_output=True,
            text=True,
        )
        token: str = json.loads(told.stdout)["token"]
        return token

    def client(self) -> httpx.Client:
        bearer = {"Authorization": f"Bearer {self.token}"}
        return httpx.Client(base_url=self.base + API, headers=bearer, timeout=60, trust_env=False)


@contextmanager
def running(workspace: Path) -> Iterator[Running]:
    """A studio with a little of everything in it."""
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser"),
            *("--json", "--workspace", str(workspace)),
        ],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        url = json.loads(process.stdout.readline())["url"]
        base, _, token = url.partition("/?token=")
        studio = Running(base, token, workspace)
        furnish(studio)
        yield studio
    finally:
        process.terminate()
        process.wait(60)
        if process.stdout is not None:
            process.stdout.close()


def furnish(studio: Running) -> None:
    """A session with takes, one of them in the trash, and an open one."""
    with studio.client() as client:
        session = client.post("/sessions", json={"scene": "asteroids", "name": "Made"}).json()["id"]
        for number in range(3):
            take = client.post(f"/sessions/{session}/takes", json={"seed": number}).json()["take"]
            actions = {"first_step": 0, "actions": [[0.05, 0.0]] * 60}
            client.post(f"/takes/{take}/actions", json=actions).raise_for_status()
        client.post(f"/takes/{take}/trash").raise_for_status()


@contextmanager
def tidied(studio: Running) -> Iterator[None]:
    """Meanwhile jobs are ended soon after they began, and only the newest stages stay open."""
    over = threading.Event()

    def watch() -> None:
        with studio.client() as client:

            def found(what: str) -> list[dict[str, Any]]:
                items: list[dict[str, Any]] = client.get(what, params={"limit": 1000}).json()[
                    "items"
                ]
                return items

            while not over.wait(TIDY_S):
                for job in found("/jobs"):
                    if job["state"] in {"queued", "running"}:
                        client.delete(f"/jobs/{job['id']}")
                for stage in found("/stages")[:-STAGES]:
                    client.delete(f"/stages/{stage['id']}")

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()


def generate(
    studio: Running, token: str, *, phases: str, examples: int, seed: int, folder: Path
) -> Found:
    """Send generated requests with `token`; what came of them. All is written to `folder`."""
    settings = folder / "schemathesis.toml"
    settings.write_text(SETTINGS)
    began = time.monotonic()
    with tidied(studio):
        done = subprocess.run(
            [
                *(sys.executable, "-m", "schemathesis.cli", "--config-file", str(settings)),
                *("run", f"{studio.base}{API}/openapi.json", "--checks", "all"),
                *("-H", f"Authorization: Bearer {token}", "--phases", phases),
                *("-n", str(examples), "--seed", str(seed)),
                *("--continue-on-failure", "--warnings", "off"),
            ],
            capture_output=True,
            text=True,
            errors="replace",
            cwd=folder,
            env={
                **os.environ,
                "SCHEMATHESIS_HOOKS": HOOKS,
                "PYTHONPATH": str(Path(__file__).parents[2]),
            },
        )
    said = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
    (folder / "said.txt").write_text(said)
    counted = re.search(r"([\d,]+) generated", said)
    cases = int(counted[1].replace(",", "")) if counted else 0
    failures = tuple(told_failures(said)) if done.returncode else ()
    return Found(cases, failures, time.monotonic() - began)


def told_failures(said: str) -> Iterator[str]:
    """Each failure that schemathesis tells of, cut to what can be read."""
    parts = re.split(r"\n(?=_{4,} .* _{4,}\n)", said)
    for part in parts[1:]:
        lines = [line[:300] for line in part.splitlines() if line.strip()]
        yield "\n".join(lines[:24])
    if len(parts) == 1:
        yield said[-2000:]


def contents(workspace: Path) -> dict[str, str]:
    """A digest of every table of the store and of every file of the workspace."""
    found = {}
    with sqlite3.connect(f"file:{workspace / 'studio.db'}?mode=ro", uri=True) as connection:
        names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        for (name,) in names.fetchall():
            rows = connection.execute(f"SELECT * FROM {name}").fetchall()
            found[name] = hashlib.sha256(repr(sorted(map(repr, rows))).encode()).hexdigest()
    connection.close()
    for path in sorted(workspace.rglob("*")):
        if path.is_file() and not path.name.startswith("studio.db"):
            found[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def run(quick: bool, seed: int) -> bool:
    """As an author and as a viewer; whether nothing was found."""
    at = commit("evastudio", "scenes", "benchmarks/soak")
    begun = time.monotonic()
    rows, held = [], True
    with tempfile.TemporaryDirectory() as place, running(Path(place) / "studio") as studio:
        for role, token in (("author", studio.token), ("viewer", studio.viewer())):
            folder = Path(place) / role
            folder.mkdir()
            before = contents(studio.workspace)
            found = generate(
                studio,
                token,
                phases="fuzzing" if quick else "examples,coverage,fuzzing",
                examples=3 if quick else EXAMPLES,
                seed=seed,
                folder=folder,
            )
            after = contents(studio.workspace)
            changed = sorted(
                Path(one).name for one in {**before, **after} if before.get(one) != after.get(one)
            )
            held = held and (quick or found.cases >= CASES) and not found.failures
            held = held and (not changed or role == "author")
            kept = "as it was"
            if changed:
                kept = "changed" if role == "author" else f"changed: {', '.join(changed)}"
            told = (role, f"{found.cases:,}", len(found.failures), kept, f"{found.seconds:.0f}")
            rows.append(f"| {' | '.join(map(str, told))} |")
            print(rows[-1], *found.failures, sep="\n\n", flush=True)
    version = metadata.version("schemathesis")
    text = "\n".join(
        [
            "## Generated requests",
            "",
            f"schemathesis {version} with all checks makes requests, valid and invalid, from the "
            "API's own description and sends them to a running studio: a failure of the server, an "
            "answer that the description does not tell of, something invalid taken in or valid "
            "refused, a request without a token answered, all count. Left out are the streams of "
            "events, which have no end. What a description cannot tell (the width of a policy's "
            "state, the range of a scene's option) may be refused as 422. Jobs that are begun so "
            "are cancelled within a second.",
            "",
            where_and_when(at, "make soak ONLY=generated", time.monotonic() - begun),
            "",
            "| as | requests | failures | store and files afterwards | s |",
            "|---|---|---|---|---|",
            *rows,
        ]
    )
    if not quick:
        write_section(ROOT / "docs" / "reliability.md", "generated", text)
    return held
