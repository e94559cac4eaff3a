"""How well do the learners answer for people, on demonstrations they have not seen?

    python benchmarks/real_data.py            # a section of docs/results.md
    python benchmarks/real_data.py --quick    # one fold, few episodes, to see that it runs

Recordings of people are read from outside the repository: `EVASTUDIO_DATA` names their folder,
else `../shared/data` beside the checkout. Each demonstration is held out once (whole experiments
of the walkers); settings are chosen on demonstrations held out of those learned from.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

import joblib

from benchmarks.real.contenders import CONTENDERS
from benchmarks.real.offline import Measured
from benchmarks.real.push import PERCEPTIONS
from benchmarks.real.recordings import data_folder
from benchmarks.real.tables import Bout, report
from benchmarks.real.walking import ConstantVelocity, StraightToGoal, displacement
from benchmarks.real.work import Job, walking, work
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.learning.compiled import ensure_compiled

FOLDS = 3
EPISODES = 50
CHUNKS = (1, 8)
"""Steps that are decided at once in the closed loop."""


def jobs(folds: int) -> list[Job]:
    """All work, the longest first."""
    offline = [
        Job(kind, fold, view)
        for kind, view in (("push", 0), ("walk", 0), ("door", 0), ("push", 1))
        for fold in range(folds)
    ]
    played = [
        Job("play", number, view, chunk, clean)
        for number in (-1, *range(2, len(CONTENDERS)))
        for view in range(len(PERCEPTIONS))
        for chunk in CHUNKS
        for clean in (False, True)
    ]
    return offline + played


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one fold, 4 episodes, few learners")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--only", help="push, door, walk or play: to work on one part")
    parser.add_argument("--out", type=Path, help="Markdown file (docs/results.md if whole)")
    options = parser.parse_args()
    data_folder()
    ensure_compiled()
    at, began = commit("evastudio/learning", "benchmarks"), time.monotonic()
    wanted = [job for job in jobs(FOLDS) if options.only in (None, job.kind)]
    if options.quick:
        wanted = [
            job for job in wanted if job.number == 0 or (job.kind == "play" and job.number < 0)
        ]
    episodes = 4 if options.quick else EPISODES
    done = joblib.Parallel(n_jobs=options.jobs, verbose=5)(
        joblib.delayed(work)(job, FOLDS, episodes) for job in wanted
    )
    measured: list[Measured] = [row for one in done if isinstance(one, list) for row in one]
    bouts = [one for one in done if isinstance(one, Bout)]
    references: dict[str, list[float]] = {}
    if any(job.kind == "walk" for job in wanted):
        for name, walker in (
            ("constant velocity", ConstantVelocity()),
            ("straight to the goal, speed kept", StraightToGoal()),
        ):
            references[name] = [
                float(displacement(walker, experiment).mean()) for experiment in walking()[0]
            ]
    command = f"python {' '.join(sys.argv)}"
    text = report(
        measured,
        bouts,
        references,
        where_and_when(at, command, time.monotonic() - began),
        FOLDS,
    )
    print(text)
    out = options.out or (None if options.quick or options.only else ROOT / "docs" / "results.md")
    if out is not None:
        write_section(out, "real data", text)


if __name__ == "__main__":
    main()
