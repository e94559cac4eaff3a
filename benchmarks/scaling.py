"""What a cluster costs and gives: one worker and two, an empty task, a byte, in docs/scaling.md.

    python -m benchmarks.scaling            # some 3 minutes
    python -m benchmarks.scaling --quick    # fewer worlds, to see that it runs

Workers are processes of one thread on this machine, over TCP. What is said of more workers than
two is reckoned from what is measured here, and said so.
"""

from __future__ import annotations

import argparse
import contextlib
import pickle
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import joblib
import numpy as np

from benchmarks.local_cluster import LocalCluster
from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.evaluation.cluster import on_cluster
from evastudio.evaluation.evaluate import CHUNK, evaluate, fly
from evastudio.learning.compiled import ensure_compiled
from evastudio.learning.policy_files import load_policy
from evastudio.pilots.policy import PolicyPilot
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene, world_seeds

ONE_CORE = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""A worker for each core, and none that takes two."""
EMPTY = 200
MEGABYTES = 16
ROUNDS = 3
AHEAD = (1, 2, 10, 100, 1000)


@dataclass(frozen=True)
class Costs:
    """What was measured, seconds of wall time."""

    task_s: float
    """Of the work in a task of `CHUNK` worlds, in this process."""
    once_bytes: int
    """What travels once to each worker: scene and pilot."""
    sent_bytes: int
    """What travels for one task."""
    back_bytes: int
    """And what comes back."""
    empty_s: float
    """Of a task that does nothing, one after the other."""
    byte_s: float
    """Of a byte that travels with a task."""
    walls_s: dict[int, float]
    """Of the whole, by the number of workers."""


def nothing(_: object) -> None:
    """A task that does nothing."""


def measure(scene: Scene, pilot: Pilot, worlds: int) -> Costs:
    """Fly `worlds` on one worker and on two, and what tasks and bytes cost."""
    seeds = world_seeds(7, CHUNK)
    fly(scene, pilot, seeds, 20_000, "")
    began = time.perf_counter()
    flown = fly(scene, pilot, seeds, 20_000, "")
    task_s = time.perf_counter() - began
    walls: dict[int, list[float]] = {1: [], 2: []}
    empty, bytes_ = [], []
    with tempfile.TemporaryDirectory() as place:
        cluster = LocalCluster(Path(place))
        with contextlib.closing(cluster):
            for workers in walls:
                cluster.work(1, **ONE_CORE)
                with on_cluster(cluster.address) as everywhere:
                    evaluate(scene, {"": pilot}, worlds=4 * CHUNK, n_jobs=everywhere, seed=1)
                    for _ in range(ROUNDS):
                        began = time.perf_counter()
                        evaluate(
                            scene,
                            {"": pilot},
                            worlds=worlds,
                            n_jobs=everywhere,
                            seed=2,
                            measure_time=False,
                        )
                        walls[workers].append(time.perf_counter() - began)
                        empty.append(spent([np.zeros(1)] * EMPTY) / EMPTY)
                        load = [np.random.default_rng(i).bytes(1_000_000) for i in range(MEGABYTES)]
                        bytes_.append(spent(load) / (MEGABYTES * 1_000_000))
    return Costs(
        task_s,
        len(pickle.dumps((scene, pilot))),
        len(pickle.dumps(seeds)),
        len(pickle.dumps(flown)),
        statistics.median(empty),
        statistics.median(bytes_),
        {workers: statistics.median(ones) for workers, ones in walls.items()},
    )


def spent(given: list[object]) -> float:
    """Wall seconds of a task that does nothing with each of `given`."""
    began = time.perf_counter()
    joblib.Parallel(n_jobs=-1, batch_size=1)(joblib.delayed(nothing)(one) for one in given)
    return time.perf_counter() - began


def report(costs: Costs, worlds: int, opening: str) -> str:
    """The document."""
    travel_s = (costs.sent_bytes + costs.back_bytes) * costs.byte_s
    here_s = costs.empty_s + travel_s
    tasks = 1_000_000 // CHUNK
    lines = [
        "# On more machines than one",
        "",
        "Written by `make bench-scaling`; do not edit by hand.",
        "",
        opening,
        "",
        "`evastudio evaluate ... --cluster tcp://HOST:PORT` (and `tune`, `paper`, `search`) runs "
        "joblib's tasks on a Dask cluster: `dask scheduler` on one machine, `dask worker "
        "tcp://HOST:PORT "
        "--nthreads 1` as often as there are cores on each, with "
        "`NUMBA_NUM_THREADS=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1` so that none takes more "
        "than one, the same "
        "versions of Python and packages everywhere, and the same code of this one, which is "
        "compared by a digest. Scenes travel as the text of their file, "
        "policies as arrays; no worker needs a file. Results do not depend on how many "
        "workers there are, nor on workers that die: their tasks are done again (tests kill "
        "one in the middle). The scheduler has no login of its own: keep it in a network that "
        "you trust, or give it TLS (Dask's `--tls-*` flags).",
        "",
        "## Measured",
        "",
        f"`asteroids-careful` through {worlds:,} fields, {CHUNK} a task, workers of one thread on "
        f"this machine; medians of {ROUNDS}.",
        "",
        "| workers | wall, s | fields a second | against one |",
        "|---:|---:|---:|---:|",
        *(
            f"| {workers} | {wall:.1f} | {worlds / wall:,.0f} | {costs.walls_s[1] / wall:.2f}x |"
            for workers, wall in costs.walls_s.items()
        ),
        "",
        "| what | cost |",
        "|---|---:|",
        f"| the work of a task | {1e3 * costs.task_s:,.0f} ms |",
        f"| a task that does nothing, there and back | {1e3 * costs.empty_s:.1f} ms |",
        f"| a megabyte that travels with a task | {1e9 * costs.byte_s:.1f} ms |",
        f"| what each worker is sent once: scene and policy | {costs.once_bytes / 1e3:,.0f} KB |",
        f"| what travels for a task of the evaluation | {costs.sent_bytes / 1e3:,.1f} KB there, "
        f"{costs.back_bytes / 1e3:,.0f} KB back |",
        "",
        "## With more workers",
        "",
        f"Reckoned for a million fields, {tasks:,} tasks: the work is shared, but one scheduler "
        "and one client hand out every task, one after the other.",
        "",
        "| workers | the work, s | handing out, s | workers busy, % at most |",
        "|---:|---:|---:|---:|",
    ]
    for workers in AHEAD:
        work, out = tasks * costs.task_s / workers, tasks * here_s
        busy = 100.0 * min(1.0, work / max(work, out))
        lines.append(f"| {workers:,} | {work:,.0f} | {out:,.0f} | {busy:.0f} |")
    full = costs.task_s / here_s
    lines += [
        "",
        f"- **10 workers**: nothing changes; up to some {full:.0f} workers are kept busy by tasks "
        "of this size.",
        "- **100 workers**: make tasks larger in the same measure (`chunk=1000` in "
        "`evastudio.evaluation.evaluate.evaluate`): the work of a task grows with its worlds, "
        "what it costs to hand out hardly does. Results stay the same.",
        "- **1,000 workers**: larger tasks still. Start-up counts then: each process compiles or "
        "loads the kernels (some seconds the first time). Scene and policy are tasks of their own: "
        "workers hand them on to each other, and the scheduler has them made again where a worker "
        "dies with them.",
        "- Tuning sends its pairs with every trial: at 100,000 pairs of 14 numbers that is 11 MB, "
        f"{11e6 * costs.byte_s:.2f} s a trial, which pays for learners that take longer than that.",
    ]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer worlds")
    options = parser.parse_args()
    worlds = 800 if options.quick else 8000
    ensure_compiled()
    scene = load_scene_file(ROOT / "scenes" / "asteroids.py")(density=4.0)
    pilot = PolicyPilot(load_policy(ROOT / "policies" / "asteroids-careful.safetensors"))
    began = time.monotonic()
    costs = measure(scene, pilot, worlds)
    command = f"python -m benchmarks.scaling {' '.join(sys.argv[1:])}".strip()
    at = commit("evastudio", "scenes", "policies", "benchmarks")
    text = report(costs, worlds, where_and_when(at, command, time.monotonic() - began))
    print(text)
    if not options.quick:
        write_section(ROOT / "docs" / "scaling.md", "scaling", text)


if __name__ == "__main__":
    main()
