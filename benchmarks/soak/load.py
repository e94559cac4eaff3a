"""Fifty stages at once, nobody looking, all recording: are decisions late, are pairs lost?

python -m benchmarks.soak --only load
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from benchmarks.soak.observed import CORES, Observed, Sample, observed
from benchmarks.soak.pages import COMING_S, drive, told
from benchmarks.soak.section import Section
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live.headless import make_scene

STAGES, SECONDS = 50, 120.0
EVERY_S = 10.0
SETTLING_S = 60.0
"""Before memory counts: by then all code is loaded and most stages have had a whole take."""
MOST_LATE = 0.01
MOST_MB = 20.0
"""So much memory may grow while it should stay flat."""


def run(quick: bool, seed: int) -> bool:
    """Whether under one in a hundred decisions was late, no pair was lost, and memory was flat."""
    section = Section("load", "scenes")
    stages, seconds = (10, 30.0) if quick else (STAGES, SECONDS)
    with tempfile.TemporaryDirectory() as folder, observed(Path(folder)) as studio:
        opened = [
            studio.open(1000 * seed + number, f"load {number}", watched=False)
            for number in range(stages)
        ]
        before = studio.sample()
        first = time.monotonic()
        pages = drive(studio.token, [stage for _, stage in opened], seconds, seed)
        samples = watch(studio, first + seconds)
        found = told(pages)
        lost = sum(
            sum((Counter(page.takes) - Counter(studio.kept(session))).elements())
            for (session, _), page in zip(opened, found, strict=True)
        )
        replayed, differing = replay_all(studio, [session for session, _ in opened])
    last = samples[-1]
    wall_s, steps = EVERY_S * len(samples), last.steps - before.steps
    late = last.late_since(before)
    settled = samples[min(int(SETTLING_S / EVERY_S), len(samples) - 1)]
    growth = last.memory_mb - settled.memory_mb
    cpu = (last.cpu_s - before.cpu_s) / wall_s
    others = (last.all_cpu_s - before.all_cpu_s) / wall_s - cpu
    section.write(
        [
            f"## {stages} stages at once",
            "",
            f"{stages} stages of asteroids without a screen, each driven through its websocket "
            "with random keys from another process, demonstrate again and again for "
            f"{seconds:.0f} s and record into SQLite; each begins at a moment of its own in the "
            f"first {COMING_S:.0f} s. The studio is held to {CORES} cores.",
            "",
            "| | measured | required |",
            "|---|---|---|",
            f"| decisions | {steps:.0f} ({steps / wall_s:.0f}/s; takes end, and three seconds "
            "pass before the next) | |",
            f"| late by over half a step (33 ms) | {late:.2%} | under {MOST_LATE:.0%} |",
            f"| late by over 200 ms | {last.late_200ms / max(steps, 1.0):.3%} | |",
            f"| takes told to the pages, and pairs | {sum(len(p.takes) for p in found)}, "
            f"{sum(sum(p.takes) for p in found)} | |",
            f"| pairs lost: of takes that the store has not as they were told | {lost} | 0 |",
            f"| takes replayed from their actions, and those that differ | {replayed}, "
            f"{differing} | 0 |",
            f"| chunks waiting for the store: median, most | "
            f"{statistics.median(s.waiting for s in samples):.0f}, "
            f"{max(s.waiting for s in samples):.0f} | |",
            f"| memory after {SETTLING_S:.0f} s and at the end | {settled.memory_mb:.0f} MB, "
            f"{last.memory_mb:.0f} MB | flat: under {MOST_MB:.0f} MB more |",
            f"| CPU of the studio, and of everything else meanwhile | {cpu:.2f} cores, "
            f"{others:.2f} cores | |",
            f"| messages to the pages | {sum(p.messages for p in found) / seconds:.0f}/s | |",
        ],
        quick,
    )
    notices = [notice for page in found for notice in page.notices]
    for notice in notices[:5]:
        print("notice:", notice)
    return late < MOST_LATE and lost == differing == 0 and growth < MOST_MB and not notices


def watch(studio: Observed, until: float) -> list[Sample]:
    """How the studio stands every few seconds."""
    samples = []
    due = time.monotonic() + EVERY_S
    while due <= until:
        time.sleep(max(0.0, due - time.monotonic()))
        samples.append(sample := studio.sample())
        print(
            f"{sample.steps:8.0f} decisions  {sample.late_steps:6.0f} late  "
            f"{sample.memory_mb:6.1f} MB  {sample.cpu_s:6.1f} s of CPU  "
            f"{sample.waiting:.0f} waiting",
            flush=True,
        )
        due += EVERY_S
    return samples


def replay_all(studio: Observed, sessions: Sequence[int]) -> tuple[int, int]:
    """How many takes there are, and of how many the actions do not give the moments again."""
    count = differing = 0
    with Store(studio.workspace.store_url) as store:
        for session in sessions:
            name = store.session(session).scene
            for take in store.takes(session):
                data = store.load_take(take.id)
                scene = make_scene(studio.workspace, name, take.options)
                again = replay_take(scene, take, data)
                same = all((again[name] == data.snapshots[name]).all() for name in again.moving)
                count += 1
                differing += not same
    return count, differing
