"""A killed server loses at most the last half second of a take, and the store just opens."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import resource
import socket
import subprocess
import sys
import time
import urllib.parse
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection, connect

from evastudio.demonstrations.records import TakeRecord
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.live.headless import make_scene
from evastudio.workspace import Workspace

if TYPE_CHECKING:
    from conftest import Studio

LOSS_S = 0.5
STAGE = {"scene": "asteroids", "options": {"density": 0.5}, "seed": 11}
LOCK = """
import sqlite3, sys
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute("begin exclusive")
print("locked", flush=True)
sys.stdin.read()
"""


Told = dict[str, Any]


@contextlib.asynccontextmanager
async def at_stage(studio: Studio, stage: Told) -> AsyncIterator[ClientConnection]:
    """A page that demonstrates."""
    headers = {"Authorization": f"Bearer {studio.token}"}
    url = studio.base.replace("http", "ws") + stage["socket"]
    async with connect(url, additional_headers=headers, proxy=None) as socket:
        await socket.send(json.dumps({"type": "command", "name": "demonstrate"}))
        await socket.send(json.dumps({"type": "keys", "held": ["KeyW"], "time_ms": 0.0}))
        yield socket


async def until(socket: ClientConnection, wanted: Callable[[Told], bool]) -> Told:
    """The first status that is as wanted."""
    while True:
        told = json.loads(await socket.recv())
        if told["type"] == "status" and wanted(told):
            return dict(told)


def recorded(pairs: int) -> Callable[[Told], bool]:
    return lambda told: told["phase"] == "recording" and told["pairs"] >= pairs


async def record_until(studio: Studio, stage: Told, pairs: int) -> tuple[int, float]:
    """Record until the stage tells of `pairs` pairs; how many, and when it told so."""
    async with at_stage(studio, stage) as socket:
        told = await until(socket, recorded(pairs))
        return told["pairs"], time.monotonic()


def check_take(workspace: Workspace) -> TakeRecord:
    """The one take of a store, whose pairs follow each other and replay."""
    with Store(workspace.store_url) as store:
        (session,) = (one for one in store.sessions() if one.demonstrator == "person")
        (take,) = store.takes(session.id)
        data = store.load_take(take.id)
    assert len(data.actions) == take.pairs
    assert np.array_equal(data.snapshots["steps"], np.arange(take.pairs))
    replayed = replay_take(make_scene(workspace, "asteroids", take.options), take, data)
    for name in data.snapshots.moving:
        assert np.array_equal(replayed[name], data.snapshots[name])
    return take


@pytest.mark.parametrize("pairs", [20, 47])
def test_a_killed_server_loses_at_most_half_a_second(
    start_studio: Callable[..., Studio], pairs: int
) -> None:
    studio = start_studio()
    stage = studio.client.post("/api/v1/stages", json=STAGE).json()
    told, at = asyncio.run(record_until(studio, stage, pairs))
    studio.kill()
    killed_after = time.monotonic() - at

    again = start_studio(studio.workspace)
    session = again.client.get("/api/v1/sessions").json()["items"][0]
    take = again.client.get(f"/api/v1/sessions/{session['id']}/takes").json()["items"][0]
    dt_s = again.client.get("/api/v1/scenes/asteroids").json()["dt_s"]
    assert take["outcome"] is None
    assert take["pairs"] * dt_s >= told * dt_s - LOSS_S
    assert take["pairs"] <= told + (killed_after + 0.2) / dt_s

    assert check_take(studio.workspace).pairs == take["pairs"]


def test_sigterm_keeps_the_running_take_whole(start_studio: Callable[..., Studio]) -> None:
    studio = start_studio()
    stage = studio.client.post("/api/v1/stages", json={"scene": "asteroids", "seed": 3}).json()
    told, _ = asyncio.run(record_until(studio, stage, 10))
    assert studio.stop() == 0
    with Store(studio.workspace.store_url) as store:
        assert store.sessions()[0].pairs >= told


class Disk:
    """A disk of 8 MB that can be filled, where one may be mounted; else files may not grow."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir()
        mounting = ["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(folder)]
        self.mounted = os.getuid() == 0 and subprocess.run(mounting, check=False).returncode == 0
        self._limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(self, studio: Studio) -> None:
        if not self.mounted:
            limits = (1, self._limits[1])
            resource.prlimit(studio.process.pid, resource.RLIMIT_FSIZE, limits)
            return
        filler = (self.folder / "filler").open("wb", buffering=0)
        with filler, contextlib.suppress(OSError):
            while True:
                filler.write(bytes(4096))

    def free(self, studio: Studio) -> None:
        if self.mounted:
            (self.folder / "filler").unlink()
        else:
            resource.prlimit(studio.process.pid, resource.RLIMIT_FSIZE, self._limits)

    def remove(self) -> None:
        if self.mounted:
            subprocess.run(["umount", str(self.folder)], check=True)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Disk]:
    made = Disk(tmp_path / "disk")
    yield made
    made.remove()


@contextlib.contextmanager
def locked(workspace: Workspace) -> Iterator[None]:
    """While another program has the store to itself."""
    with subprocess.Popen(
        [sys.executable, "-c", LOCK, str(workspace.root / "studio.db")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline()
        yield
        other.communicate()


async def fly_through_a_full_disk(
    studio: Studio, stage: Told, disk: Disk, where: str
) -> tuple[str, int]:
    """What was told while the disk was full, once the take was kept elsewhere, and how many pairs
    there were in the end."""
    async with at_stage(studio, stage) as socket:
        await until(socket, recorded(10))
        disk.fill(studio)
        trouble = await until(socket, lambda told: where in (told["problem"] or ""))
        await until(socket, recorded(trouble["pairs"] + 15))
        disk.free(studio)
        well = await until(socket, lambda told: told["problem"] is None)
        await until(socket, recorded(well["pairs"] + 5))
        await socket.send(json.dumps({"type": "command", "name": "stop"}))
        ended = await until(socket, lambda told: told["phase"] == "ready")
        return trouble["problem"], ended["pairs"]


def test_a_take_goes_on_while_the_disk_is_full(
    start_studio: Callable[..., Studio], disk: Disk, tmp_path: Path
) -> None:
    place = Workspace(disk.folder / "work")
    studio = start_studio(place, XDG_CACHE_HOME=str(tmp_path / "cache"))
    where = str(tmp_path / "cache") if disk.mounted else "in memory"
    try:
        stage = studio.client.post("/api/v1/stages", json=STAGE).json()
        problem, pairs = asyncio.run(fly_through_a_full_disk(studio, stage, disk, where))
    finally:
        studio.stop()
    assert problem.startswith("Recording goes on in")
    assert check_take(place).pairs == pairs
    assert not list(tmp_path.rglob("*.unsaved"))


async def fly_into_a_lock(
    studio: Studio, stage: Told, then: Callable[[], object]
) -> tuple[int, float]:
    """Record with the store locked, do `then`, and say how many pairs were told of before."""
    async with at_stage(studio, stage) as socket:
        free = await until(socket, recorded(10))
        with locked(studio.workspace):
            told = await until(socket, recorded(free["pairs"] + 20))
            await asyncio.to_thread(then)
            return told["pairs"], time.monotonic()


def test_a_studio_killed_while_the_store_is_locked_loses_at_most_half_a_second(
    start_studio: Callable[..., Studio],
) -> None:
    studio = start_studio()
    stage = studio.client.post("/api/v1/stages", json=STAGE).json()
    told, _ = asyncio.run(fly_into_a_lock(studio, stage, studio.kill))
    again = start_studio(studio.workspace)
    dt_s = again.client.get("/api/v1/scenes/asteroids").json()["dt_s"]
    assert check_take(studio.workspace).pairs * dt_s >= told * dt_s - LOSS_S
    assert not (studio.workspace.root / "unsaved").exists()


def test_sigterm_ends_a_studio_that_everything_holds_up(
    start_studio: Callable[..., Studio], tmp_path: Path
) -> None:
    workspace = Workspace(tmp_path / "studio").ready()
    session = headless.record(workspace, "asteroids", minutes=1.0)["session"]
    studio = start_studio(workspace)
    stage = studio.client.post("/api/v1/stages", json=STAGE).json()
    job = studio.client.post(f"/api/v1/sessions/{session}/tune", json={}).json()
    assert job["kind"] == "tune"
    address = urllib.parse.urlsplit(studio.base)
    assert address.hostname is not None
    assert address.port is not None
    with socket.create_connection((address.hostname, address.port)) as slow:
        slow.sendall(b"POST /api/v1/stages HTTP/1.1\r\nHost: ")
        told, _ = asyncio.run(fly_into_a_lock(studio, stage, lambda: assert_clean(studio)))
    assert list((workspace.root / "unsaved").iterdir())
    start_studio(workspace)
    assert check_take(workspace).pairs >= told


def assert_clean(studio: Studio) -> None:
    assert studio.stop() == 0
