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
from typing import Any

import joblib

from benchmarks.real.contenders import CONTENDERS
from benchmarks.real.offline import Measured
from benchmarks.real.push import PERCEPTIONS
from benchmarks.real.recordings import data_folder, read_door, read_push
from benchmarks.real.tables import Bout, errors_report, played_report
from benchmarks.real.walking import ConstantVelocity, StraightToGoal, displacement
from benchmarks.real.work import Job, walking, work
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.delay import estimate_delay_of_arrays

FOLDS = 3
EPISODES = 50
CHUNKS = (4, 8)
"""Steps that are decided at once in the closed loop, beside one."""
FIRST_PLAYED = 2
"""The constant and the linear one are not played."""
IN_CHUNKS = ("MLP", "k-NN", "sampled k-NN")


def offline_jobs(folds: int) -> list[Job]:
    """Errors of every learner, the longest work first."""
    return [
        Job(kind, fold, view)
        for kind, view in (("walk", 0), ("push", 0), ("door", 0), ("push", 1))
        for fold in range(folds)
    ]


def played_jobs() -> list[Job]:
    """Everyone one step at a time, raw and cleaned; some that see the block in several at once."""
    views, clean = range(len(PERCEPTIONS)), (False, True)
    learners = range(FIRST_PLAYED, len(CONTENDERS))
    return [
        *(Job("play", at, view, 1, c) for at in (-1, *learners) for view in views for c in clean),
        *(Job("play", -1, view, CHUNKS[0]) for view in views),
        *(Job("play", at, 1, CHUNKS[0]) for at in learners if CONTENDERS[at].name in IN_CHUNKS),
        Job("play", -1, 1, CHUNKS[0], True),
        Job("play", -1, 1, CHUNKS[1]),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="door's first fold, 2 episodes")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--only", choices=("errors", "played"), help="one half of it")
    parser.add_argument("--out", type=Path, help="Markdown file (docs/results.md if not quick)")
    options = parser.parse_args()
    data_folder()
    ensure_compiled()
    at = commit("evastudio/learning", "benchmarks")
    command = f"python {' '.join(sys.argv)}"
    out = options.out or (None if options.quick else ROOT / "docs" / "results.md")

    def do(jobs: list[Job], episodes: int) -> list[Any]:
        return list(
            joblib.Parallel(n_jobs=options.jobs, batch_size=1, verbose=5)(
                joblib.delayed(work)(job, FOLDS, episodes) for job in jobs
            )
        )

    def hand_out(name: str, text: str) -> None:
        print(text, flush=True)
        if out is not None:
            write_section(out, name, text)

    if options.only != "errors":
        began = time.monotonic()
        jobs = [Job("play", -1)] if options.quick else played_jobs()
        bouts: list[Bout] = do(jobs, 2 if options.quick else EPISODES)
        where = where_and_when(at, command, time.monotonic() - began)
        hand_out("push-t played", played_report(bouts, where))
    if options.only != "played":
        began = time.monotonic()
        jobs = [Job("door", 0)] if options.quick else offline_jobs(FOLDS)
        measured: list[Measured] = [row for rows in do(jobs, 0) for row in rows]
        references = {} if options.quick else walked_anyway()
        delays = natural_delays()
        where = where_and_when(at, command, time.monotonic() - began)
        hand_out("real data", errors_report(measured, references, delays, where, FOLDS))


def walked_anyway() -> dict[str, list[float]]:
    """How far off those are who learn nothing, in each experiment."""
    return {
        name: [float(displacement(walker, one).mean()) for one in walking()[0]]
        for name, walker in (
            ("constant velocity", ConstantVelocity()),
            ("straight to the goal, speed kept", StraightToGoal()),
        )
    }


def natural_delays() -> dict[str, str]:
    """What the estimate says of the recordings in which a delay could be."""
    said = {}
    for one in (read_push(data_folder(), PERCEPTIONS[0]), read_door(data_folder())):
        pairs = one.pairs
        delay = estimate_delay_of_arrays(pairs.states, pairs.actions, pairs.takes, one.dt_s)
        said[one.name] = (
            f"the least error at {delay.delay_s:.2f} s ({delay.low_s:.2f} to {delay.high_s:.2f}), "
            f"{delay.steps * one.dt_s:.2f} s to take out. {delay.sentence()}"
        )
    return said


if __name__ == "__main__":
    main()
