"""Figures: how fast a crowd is posed and drawn, and how far feet slide, shipped and imported.

    python benchmarks/motion.py          # writes docs/motion.md
    python benchmarks/motion.py --print  # says it only

Clips of others are read from outside the repository: `EVASTUDIO_DATA` names their folder, else
it is `../shared/data` beside the checkout. CPU time of this process, medians.
"""

from __future__ import annotations

import argparse
import asyncio
import re
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import uvicorn
from fastapi import FastAPI, WebSocket
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.real.recordings import data_folder  # noqa: E402
from benchmarks.report import commit, where_and_when, write_section  # noqa: E402
from evastudio.errors import InvalidInputError  # noqa: E402
from evastudio.motion.body import OFFSETS, PARENTS, UPPER  # noqa: E402
from evastudio.motion.clip import Clip  # noqa: E402
from evastudio.motion.figures import SPEEDS, Figures  # noqa: E402
from evastudio.motion.gait import RUNNING, gait  # noqa: E402
from evastudio.motion.glb import Glb  # noqa: E402
from evastudio.motion.mocap import read_mocap  # noqa: E402
from evastudio.motion.moment import Activity, Moment  # noqa: E402
from evastudio.motion.retarget import retargeted  # noqa: E402
from evastudio.motion.rotations import product, rotated  # noqa: E402
from evastudio.motion.skeleton import Skeleton  # noqa: E402
from evastudio.motion.sliding import sliding_cm  # noqa: E402
from evastudio.motion.steps import gait_of  # noqa: E402
from evastudio.studio.mounted import SUBPROTOCOL  # noqa: E402
from evastudio.studio.view import View  # noqa: E402
from evastudio.world.bodies import Body, Camera, Look, Mesh  # noqa: E402
from evastudio.world.scene import Scene  # noqa: E402
from evastudio.world.snapshot import Snapshot  # noqa: E402
from evastudio.world.spaces import Array, Box, Field  # noqa: E402

ALLOWED_CM = 3.0
FRAMES_HZ = 30.0
WATCHED_S = 6.0
CLIENT = """
import asyncio, sys
from websockets.asyncio.client import connect
async def watch():
    async with connect(sys.argv[1], subprotocols=[sys.argv[2]], max_size=None) as client:
        async for message in client: pass
asyncio.run(watch())
"""
"""A browser's part, in a process of its own: it takes what comes."""
FIGURES = Figures()


class Parade(Scene):
    """People who walk in circles: all that a view needs to be measured."""

    name = "parade"
    title = "Parade"
    version = 1
    dt_s = 0.1
    render_hz = FRAMES_HZ
    outcomes = ("running", "done")
    successes = frozenset({"done"})
    action = Box((Field("none", "1", -1.0, 1.0),))
    perceptions: ClassVar[Mapping[str, Any]] = {}
    look = Look((150, 170, 190), 50.0, 200.0, (0.3, 0.2, 1.0))

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        return Snapshot({"count": np.full(worlds, 10)}, {"time": np.zeros(worlds)})

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        return snapshot.after(time=snapshot["time"] + self.dt_s)

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        return np.zeros(snapshot.worlds, dtype=np.int64)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.zeros(snapshot.worlds)

    def meshes(self) -> Mapping[str, Mesh]:
        return FIGURES.meshes()

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        moment = crowd(int(snapshot["count"][0]), float(snapshot["time"][0]))
        return FIGURES.bodies(moment)

    def camera(self, snapshot: Snapshot) -> Camera:
        return Camera(np.array([0.0, -60.0, 30.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]))


def crowd(count: int, time_s: float) -> Moment:
    """`count` people of all sorts at one moment."""
    rng = np.random.default_rng(count)
    radius, speeds = rng.uniform(3.0, 60.0, count), rng.uniform(0.0, 2.5, count)
    turns = speeds / radius
    angle = rng.uniform(0, 2 * np.pi, count) + turns * time_s
    sizes, manners = rng.uniform(0.9, 1.1, count), rng.uniform(-1, 1, count)
    phases = rng.uniform(0, 1, count) + FIGURES.cadence(speeds, turns, sizes, manners) * time_s
    return Moment(
        np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1),
        angle + np.pi / 2,
        speeds,
        phases,
        turns,
        times_s=rng.uniform(0, 6, count) + time_s,
        sizes=sizes,
        manners=manners,
        looks=np.arange(count),
    )


def one_of(moment: Moment, row: int) -> Moment:
    return Moment(**{name: array[row : row + 1] for name, array in vars(moment).items()})


def plain(moment: Moment) -> list[Any]:
    """The simplest program for it: a clip sampled and a skeleton posed, character by character.

    It neither blends clips nor bends legs.
    """
    placed = []
    for row in range(len(moment.positions)):
        time_s = np.array([float(moment.phases[row]) % 1.0])
        positions, turns = SKELETON.posed(*WALK.sample(time_s))
        half = moment.headings[row] / 2
        heading = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
        placed.append((rotated(heading, positions[0]), product(heading, turns[0])))
    return placed


SKELETON = Skeleton(UPPER + ("leg",) * 6, (*PARENTS, 0, 9, 10, 0, 12, 13), np.zeros((15, 3)))
"""As many joints as a figure has."""


def walk_clip() -> Clip:
    poses = gait(1.2).poses
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(poses), 15, 1))
    turns[:, :9] = poses.upper
    offsets = np.zeros((len(poses), 15, 3))
    offsets[:, :9] = OFFSETS
    return Clip("walk", SKELETON, float(len(poses) - 1), offsets, turns)


WALK = walk_clip()


def parading(count: int) -> Callable[[float], Snapshot]:
    """`count` people on parade at each second."""
    return lambda time_s: Snapshot({}, {"count": np.array([count]), "time": np.array([time_s])})


def cpu_ms(work: Callable[[], Any], repetitions: int) -> float:
    work()
    spent = []
    for _ in range(repetitions):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return 1e3 * statistics.median(spent)


def watched(scene: Scene, at: Callable[[float], Snapshot]) -> tuple[float, float]:
    """CPU ms a frame and frames a second, as one browser watches what is `at` each second."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    view = View(scene, loop)
    app = FastAPI()

    @app.websocket("/view")
    async def socket_of_view(websocket: WebSocket) -> None:
        await view.handle(websocket)

    listening = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            ws="websockets-sansio",
            ws_per_message_deflate=False,
            log_level="warning",
            lifespan="off",
        )
    )
    serving = asyncio.run_coroutine_threadsafe(server.serve(sockets=[listening]), loop)
    address = f"ws://127.0.0.1:{listening.getsockname()[1]}/view"
    client = subprocess.Popen([sys.executable, "-c", CLIENT, address, SUBPROTOCOL])

    def frame(number: int) -> None:
        view.show(at(number / FRAMES_HZ), fresh=number == 0)

    frame(0)
    while view.clients == 0:
        time.sleep(0.05)
    frames = int(WATCHED_S * FRAMES_HZ)
    for number in range(10):
        frame(number)
    begin, spent = time.monotonic(), time.process_time()
    for number in range(frames):
        frame(number)
        time.sleep(max(0.0, begin + (number + 1) / FRAMES_HZ - time.monotonic()))
    lasted, spent = time.monotonic() - begin, time.process_time() - spent
    loop.call_soon_threadsafe(view.close)
    server.should_exit = True
    serving.result(30)
    client.wait(30)
    loop.call_soon_threadsafe(loop.stop)
    thread.join(30)
    listening.close()
    return 1e3 * spent / frames, frames / lasted


def speed_table() -> Iterator[str]:
    yield (
        "| people | joints | joints and what to draw | one at a time | plain loop | "
        "watched at 30 Hz | frames a second |"
    )
    yield "|---|---|---|---|---|---|---|"
    for count, alone in ((10, 10), (100, 100), (1000, 1000), (10_000, 200)):
        moment = crowd(count, 1.0)
        repeats = max(5, 20_000 // count) if count < 10_000 else 9
        joints = cpu_ms(lambda m=moment: FIGURES.joints(m), repeats)
        bodies = cpu_ms(lambda m=moment: FIGURES.bodies(m), repeats)
        few = crowd(alone, 1.0)
        single = [one_of(few, row) for row in range(alone)]
        one = cpu_ms(lambda s=single: [FIGURES.bodies(m) for m in s], 3) * count / alone
        loop = cpu_ms(lambda f=few: plain(f), 3) * count / alone
        frame, rate = watched(Parade(), parading(count))
        yield (
            f"| {count:,} | {joints:.2f} ms | {bodies:.2f} ms | {one:,.0f} ms | {loop:,.0f} ms "
            f"({loop / bodies:,.0f} times) | {frame:.1f} ms, {frame * FRAMES_HZ / 10:.0f} % of a "
            f"core | {rate:.0f} |"
        )


def shipped_table() -> Iterator[str]:
    yield "| speed m/s | shy | plain | hurried | plain, turning 0.8 rad/s |"
    yield "|---|---|---|---|---|"
    for speed in (0.25, *SPEEDS[1:], 0.9, 1.4, 2.1, 3.2):
        row = [sliding_cm(FIGURES, speed, 0.0, manner).max() for manner in (-1.0, 0.0, 1.0)]
        row.append(sliding_cm(FIGURES, speed, 0.8).max())
        yield f"| {speed:g} | " + " | ".join(f"{cm:.1f}" for cm in row) + " |"
    spot = max(sliding_cm(FIGURES, 0.0, rate).max() for rate in (0.5, 1.0, 2.0))
    yield f"| 0, turning 0.5, 1 or 2 rad/s | | {spot:.1f} | | |"


def imported() -> Iterator[tuple[str, str, Clip]]:
    folder = data_folder()
    for path in sorted((folder / "gltf").glob("*.glb")):
        glb = Glb(path.read_bytes(), path.name)
        for name in glb.clip_names:
            if re.match(r"walk|run", name, re.IGNORECASE):
                yield path.name, name, glb.clip(name)
    for path in sorted((folder / "mocap").glob("humanoid3d_*.txt")):
        yield (
            path.name,
            path.stem.removeprefix("humanoid3d_"),
            read_mocap(path.read_bytes(), path.stem),
        )


def imported_table() -> Iterator[str]:
    yield (
        "| file | clip | speed m/s | steps m | as it is, cm | half as fast again, cm | "
        "turning 0.5 rad/s, cm |"
    )
    yield "|---|---|---|---|---|---|---|"
    for file, name, clip in imported():
        try:
            found = gait_of(retargeted(clip), clip.rate_hz, name)
        except InvalidInputError as error:
            yield f"| {file} | {name} | | | refused: {error} | | |"
            continue
        figures = Figures({Activity.RUN if found.speed >= RUNNING else Activity.WALK: found})
        slid = [
            sliding_cm(figures, *way).max()
            for way in ((found.speed,), (1.5 * found.speed,), (found.speed, 0.5))
        ]
        yield (
            f"| {file} | {name} | {found.speed:.2f} | {found.stride_m / 2:.2f} | "
            + " | ".join(f"{cm:.1f}" for cm in slid)
            + " |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--print", action="store_true", help="write no document")
    chosen = parser.parse_args()
    begin = time.monotonic()
    parts = {
        "Speed, CPU of the whole process": speed_table(),
        f"Shipped gaits: cm a foot slides a step ({ALLOWED_CM:g} allowed)": shipped_table(),
        f"Imported walks and runs ({ALLOWED_CM:g} cm allowed)": imported_table(),
    }
    text = "\n\n".join(f"## {title}\n\n" + "\n".join(rows) for title, rows in parts.items())
    at = commit("evastudio/motion", "evastudio/studio", "benchmarks/motion.py")
    line = where_and_when(at, "python benchmarks/motion.py", time.monotonic() - begin)
    print(f"{line}\n\n{text}")
    if not chosen.print:
        write_section(ROOT / "docs" / "motion.md", "measured", f"{line}\n\n{text}")


if __name__ == "__main__":
    main()
