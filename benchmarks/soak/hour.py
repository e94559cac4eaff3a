"""One stage for an hour, with what a page sends and is sent: does memory grow?

python -m benchmarks.soak --only hour
python -m benchmarks.soak.hour --minutes 5   # a shorter one; writes nothing
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.soak.observed import Sample, observed
from benchmarks.soak.pages import drive, told
from benchmarks.soak.section import Section

MINUTES = 60.0
SETTLING_MINUTES = 1.0
"""Growth counts from then on: by then every kind of thing was done once."""
MOST_MB = 20.0


def run(quick: bool, seed: int, minutes: float | None = None) -> bool:
    """Whether memory grew by less than is allowed, and no pair was lost."""
    lasting = minutes or (2.0 if quick else MINUTES)
    section = Section("hour", "scenes")
    samples: list[Sample] = []
    with tempfile.TemporaryDirectory() as folder, observed(Path(folder)) as studio:
        session, stage = studio.open(seed, "an hour", watched=True)
        pages = drive(studio.token, [stage], lasting * 60.0, seed)
        first = time.monotonic()
        for minute in range(int(lasting) + 1):
            time.sleep(max(0.0, first + 60.0 * minute - time.monotonic()))
            sample = studio.sample()
            samples.append(sample)
            print(
                f"{minute:3} min  {sample.memory_mb:7.1f} MB  {sample.steps:7.0f} steps", flush=True
            )
        (page,) = told(pages)
        kept = sum(studio.kept(session))
    growth = samples[-1].memory_mb - samples[int(SETTLING_MINUTES)].memory_mb
    lost = sum(page.takes) - kept
    table = "\n".join(
        f"| {minute} | {sample.memory_mb:.1f} | {sample.steps:.0f} |"
        for minute, sample in enumerate(samples)
        if minute % 10 == 0 or minute in (1, len(samples) - 1)
    )
    steps, late = samples[-1].steps, samples[-1].late_steps
    cpu = (samples[-1].cpu_s - samples[0].cpu_s) / (60.0 * int(lasting))
    seen_mb = page.view_bytes / 1e6
    section.write(
        [
            f"## One stage for {lasting:.0f} minutes",
            "",
            "A page without a browser drives one stage of asteroids with random keys, four changes "
            "a second, and takes in its status and every frame of the 3D view; it demonstrates "
            f"again and again ({len(page.takes)} takes). Memory of the studio, resident:",
            "",
            "| minute | MB | decisions |",
            "|---|---|---|",
            table,
            "",
            f"It grew by {growth:.1f} MB after the first minute (allowed: {MOST_MB:.0f}). Of "
            f"{steps:.0f} decisions {late:.0f} were late ({late / max(steps, 1):.2%}), {lost} of "
            f"{sum(page.takes)} pairs were lost, {page.messages} messages and {seen_mb:.0f} MB of "
            f"frames were sent; {cpu:.2f} cores of CPU.",
        ],
        quick or minutes is not None,
    )
    return growth < MOST_MB and lost == 0 and not page.notices


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak.hour")
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=6)
    given = parser.parse_args()
    sys.exit(0 if run(False, given.seed, given.minutes) else 1)
