"""One stage while jobs fit in the background, one after another: does it keep its step?

python -m benchmarks.soak --only fitting
"""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.soak.observed import CORES, Observed, observed
from benchmarks.soak.pages import Stage, drive, told
from benchmarks.soak.section import Section
from evastudio.live import headless

SECONDS = 120.0
MINUTES = 10.0
"""Demonstrated by a script before, to be fitted."""
MOST_LATE = 0.01
JOBS = ({"learner": "svr"}, {"learner": "auto"})
"""What is fitted, in turn: with settings as they are, and with the settings that a tuning found."""
EVERY_S = 0.25


@dataclass
class Fitted:
    """What ran in the background."""

    jobs: int = 0
    seconds: float = 0.0
    errors: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Kept:
    """How the stage kept its step."""

    steps: float
    late: float
    """Share that began over half a step late."""
    very_late: float
    """Share that began over 200 ms late."""
    lost: int
    """Pairs told to the page that the store lacks."""
    cpu: float
    """Cores that the studio's own process used."""
    others: float
    """Cores that everything else used, jobs and page too."""


def run(quick: bool, seed: int) -> bool:
    """Whether under one in a hundred decisions was late, and no pair was lost."""
    section = Section("fitting", "scenes")
    seconds, minutes = (20.0, 2.0) if quick else (SECONDS, MINUTES)
    with tempfile.TemporaryDirectory() as folder, observed(Path(folder)) as studio:
        made = headless.record(
            studio.workspace, "asteroids", minutes=minutes, seed=seed, session="To fit"
        )
        session, stage = studio.open(seed, "while it fits", watched=True)
        alone = flown(studio, session, stage, seconds / 2, seed)
        with fitting(studio, int(made["session"])) as fitted:
            beside = flown(studio, session, stage, seconds, seed + 1)
        load = os.getloadavg()[0]
    section.write(
        [
            f"## One stage while jobs fit, for {seconds / 60:.0f} minutes",
            "",
            "A page without a browser drives one stage of asteroids with random keys and takes in "
            "its status and every frame of the 3D view. First nothing else is asked of the studio; "
            f"then it fits {minutes:.0f} minutes of takes, again and again, by SVR and with "
            f"settings chosen for it in turn. The studio and its jobs are held to {CORES} cores.",
            "",
            "| | alone | while it fits | required |",
            "|---|---|---|---|",
            f"| decisions | {alone.steps:.0f} | {beside.steps:.0f} | |",
            f"| late by over half a step (33 ms) | {alone.late:.2%} | {beside.late:.2%} | under "
            f"{MOST_LATE:.0%} |",
            f"| late by over 200 ms | {alone.very_late:.2%} | {beside.very_late:.2%} | |",
            f"| pairs lost | {alone.lost} | {beside.lost} | 0 |",
            f"| CPU of the studio without its jobs | {alone.cpu:.2f} cores | {beside.cpu:.2f} "
            "cores | |",
            f"| CPU of jobs, page and everything else | {alone.others:.2f} cores | "
            f"{beside.others:.2f} cores | |",
            "",
            f"{fitted.jobs} jobs ended in {fitted.seconds:.0f} s. Load of the machine in the last "
            f"minute: {load:.1f}.",
        ],
        quick,
    )
    for line in fitted.errors[:5]:
        print("a job failed:", line)
    return beside.late < MOST_LATE and alone.lost == beside.lost == 0 and not fitted.errors


def flown(studio: Observed, session: int, stage: Stage, seconds: float, seed: int) -> Kept:
    """Demonstrate at the stage for so long."""
    held = sum(studio.kept(session))
    before, began = studio.sample(), time.monotonic()
    (page,) = told(drive(studio.token, [stage], seconds, seed))
    after, wall_s = studio.sample(), time.monotonic() - began
    cores = (after.cpu_s - before.cpu_s) / wall_s
    return Kept(
        after.steps - before.steps,
        after.late_since(before),
        after.very_late_since(before),
        sum(page.takes) - (sum(studio.kept(session)) - held),
        cores,
        (after.all_cpu_s - before.all_cpu_s) / wall_s - cores,
    )


@contextmanager
def fitting(studio: Observed, session: int) -> Iterator[Fitted]:
    """Jobs run, one after another, within the block."""
    found, enough = Fitted(), threading.Event()

    def ended(job: dict[str, Any]) -> dict[str, Any]:
        while job["state"] in {"queued", "running"} and not enough.wait(EVERY_S):
            job = studio.client.get(f"/api/v1/jobs/{job['id']}").json()
        return job

    def work() -> None:
        began = time.monotonic()
        while not enough.is_set():
            body = {**JOBS[found.jobs % len(JOBS)], "name": "fitted"}
            answer = studio.client.post(f"/api/v1/sessions/{session}/fit", json=body)
            job = ended(answer.raise_for_status().json())
            if job["state"] == "failed":
                found.errors.append(job["error"])
            if enough.is_set():
                studio.client.delete(f"/api/v1/jobs/{job['id']}")
                break
            found.jobs += 1
        found.seconds = time.monotonic() - began

    working = threading.Thread(target=work)
    working.start()
    try:
        yield found
    finally:
        enough.set()
        working.join()
