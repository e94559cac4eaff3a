"""How many steps a second a program gets out of a headless world, by each way: docs/worlds.md.

    python -m benchmarks.stepping            # about a minute

All in one run: the scene alone, a batch without a server, and through loopback the websocket with
many steps on their way and with one, and HTTP. CPU is that of both processes together.
"""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.client import HeadlessWorlds, Studio
from evastudio.live.batch import Batch
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot
from evastudio.workspace import Workspace
from evastudio.world.compiled import load

ROUNDS, STEPS = 5, 1000
"""Every way in turn, so often; steps of each, in worlds of SEEDS that are begun anew in time."""
LONG = 250
"""Steps in one world, of a crossing's 550."""
COMMAND = "python -m benchmarks.stepping"


@contextmanager
def studio(folder: Path) -> Iterator[tuple[str, int]]:
    """A studio that runs: its address, and its process."""
    run = [sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser", "--json"]
    process = subprocess.Popen(
        [*run, "--workspace", str(folder)], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    assert process.stdout is not None
    try:
        yield json.loads(process.stdout.readline())["url"], process.pid
    finally:
        process.terminate()
        process.wait()


def cpu_s(*processes: int) -> float:
    """CPU time that they have used so far."""
    ticks = 0
    for process in processes:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def plainly(folder: Path) -> Callable[[], None]:
    """The scene's own functions, and nothing else."""
    scene = make_scene(Workspace(folder), "asteroids")
    view, still = scene.perception(), np.zeros((1, 2))
    seeds = itertools.count()

    def run() -> None:
        for step in range(STEPS):
            if step % LONG == 0:
                world = scene.worlds([next(seeds)])
            world = scene.step(world, still)
            view.perceive(world)
            scene.outcome(world)
            scene.progress(world)

    return run


def in_a_batch(folder: Path) -> Callable[[], None]:
    place = Workspace(folder)
    scene = make_scene(place, "asteroids")
    batch = Batch("x", scene, [0], pilots=lambda name: load_pilot(place, name, scene))
    still, seeds = np.zeros((1, 2)), itertools.count()

    def run() -> None:
        for step in range(STEPS):
            if step % LONG == 0:
                batch.reset([next(seeds)])
            batch.step(still)

    return run


def by_stream(worlds: HeadlessWorlds, ahead: int) -> Callable[[], None]:
    stream = worlds.stream().__enter__()
    still, seeds = np.zeros((1, 2)), itertools.count()

    def run() -> None:
        for _ in range(STEPS // LONG):
            stream.reset([next(seeds)])
            for _ in stream.steps(itertools.repeat(still, LONG), ahead):
                pass

    return run


def by_requests(worlds: HeadlessWorlds, together: int) -> Callable[[], None]:
    still, seeds = np.zeros((together, 1, 2)), itertools.count()

    def run() -> None:
        for _ in range(STEPS // LONG):
            worlds.reset([next(seeds)])
            for _ in range(LONG // together):
                worlds.step(still)

    return run


def main() -> None:
    began = time.monotonic()
    load()
    with (
        tempfile.TemporaryDirectory() as folder,
        studio(Path(folder)) as (url, server),
        Studio(url) as far,
    ):
        worlds = [far.worlds.open("asteroids", [0]) for _ in range(4)]
        ways = {
            "the scene alone, in process": plainly(Path(folder)),
            "a batch, in process": in_a_batch(Path(folder)),
            "websocket, 16 on their way": by_stream(worlds[0], 16),
            "websocket, one at a time": by_stream(worlds[1], 1),
            "HTTP, 50 steps a request": by_requests(worlds[2], 50),
            "HTTP, one step a request": by_requests(worlds[3], 1),
        }
        measured: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
        for run in ways.values():
            run()  # once unmeasured: connections, compiled code
        for _ in range(ROUNDS):
            for name, run in ways.items():
                wall, cpu = time.perf_counter(), cpu_s(os.getpid(), server)
                run()
                spent = cpu_s(os.getpid(), server) - cpu
                measured[name].append((time.perf_counter() - wall, spent))
    lines = ["| way | steps a second | of the scene alone | CPU a step |", "|---|---|---|---|"]
    alone = np.median([wall for wall, _ in measured["the scene alone, in process"]])
    for name, found in measured.items():
        wall, cpu = np.median(found, axis=0)
        lines.append(
            f"| {name} | {STEPS / wall:,.0f} | {alone / wall:.0%} | {cpu / STEPS * 1e6:,.0f} us |"
        )
    told = where_and_when(commit("evastudio", "scenes"), COMMAND, time.monotonic() - began)
    busy = f"{os.getloadavg()[1]:.0f} processes wanted {os.cpu_count()} cores"
    how = f"- Medians of {ROUNDS} rounds of {STEPS} steps; CPU of both processes; {busy}."
    text = f"{told}\n{how}\n\n" + "\n".join(lines)
    print(text)
    write_section(ROOT / "docs" / "worlds.md", "stepping", text)


if __name__ == "__main__":
    main()
