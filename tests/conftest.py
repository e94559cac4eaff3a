"""What many tests need: a scene, a workspace, and a studio that really runs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import httpx
import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from evastudio.demonstrations.store import Store
from evastudio.learning.compiled import ensure_compiled
from evastudio.workspace import Workspace, shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene
from tests.postgres import Postgres

START_S = 60.0

# No test asserts how long anything takes.
settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")


class Rooms(LoadScopeScheduling):  # type: ignore[misc]
    """Which tests stay together where several processes share them: those of a file, and all that
    draw in a browser, which takes more than a processor by itself."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return "browser" if file.startswith("tests/browser/") else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Rooms:
    return Rooms(config, log)


@pytest.fixture(scope="session", autouse=True)
def compiled() -> None:
    """Tests time out on what they wait for, not on the compiler."""
    ensure_compiled()


@pytest.fixture(scope="session")
def asteroids() -> Callable[..., Scene]:
    """The class of the shipped asteroid field."""
    return load_scene_file(shipped() / "scenes" / "asteroids.py")


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return Workspace(tmp_path / "work").ready()


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    """A PostgreSQL server of the tests' own."""
    server = Postgres()
    try:
        server.start()
        yield server
    finally:
        server.remove()


@pytest.fixture
def postgres_url(postgres: Postgres) -> Iterator[str]:
    """The address of an empty database."""
    name = postgres.create_database()
    yield postgres.url(name)
    postgres.empty_database(name)


@pytest.fixture(params=["sqlite", "postgres"])
def store_url(request: pytest.FixtureRequest) -> str:
    """The address of a new store, once in each database."""
    if request.param == "postgres":
        return str(request.getfixturevalue("postgres_url"))
    return f"sqlite:///{request.getfixturevalue('tmp_path') / 'store.db'}"


@pytest.fixture
def store(store_url: str) -> Iterator[Store]:
    with Store(store_url) as opened:
        yield opened


@dataclass
class Studio:
    """A studio in a process of its own."""

    process: subprocess.Popen[str]
    url: str
    """As printed, token included."""
    workspace: Workspace
    client: httpx.Client = field(init=False)

    def __post_init__(self) -> None:
        self.client = httpx.Client(
            base_url=self.base,
            headers={"Authorization": f"Bearer {self.token}"},
            timeout=30.0,
            trust_env=False,
        )

    @property
    def base(self) -> str:
        return self.url.partition("/?")[0]

    @property
    def token(self) -> str:
        return self.url.partition("token=")[2]

    def kill(self) -> None:
        """As `kill -9` does."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> int:
        """As SIGTERM does; the exit code."""
        self.client.close()
        self.process.terminate()
        code = self.process.wait(timeout=30)
        output: IO[str] | None = self.process.stdout
        if output is not None:
            output.close()
        return code


@pytest.fixture
def start_studio(tmp_path: Path) -> Iterator[Callable[..., Studio]]:
    """Start a studio on a workspace; all are stopped after the test."""
    running: list[Studio] = []

    def start(
        workspace: Workspace | None = None, python: str = sys.executable, **environment: str
    ) -> Studio:
        place = workspace or Workspace(tmp_path / "studio")
        studio = launch(place, python, **environment)
        running.append(studio)
        return studio

    yield start
    for studio in running:
        if studio.process.poll() is None:
            studio.stop()
        else:
            studio.client.close()
            if studio.process.stdout is not None:
                studio.process.stdout.close()


def launch(
    workspace: Workspace,
    python: str = sys.executable,
    arguments: Sequence[str] = (),
    events: IO[str] | None = None,
    **environment: str,
) -> Studio:
    """A studio on a free port, once it listens; what it writes of events goes to `events`."""
    process = subprocess.Popen(
        [
            *(python, "-m", "evastudio", "studio", "--port", "0", "--no-browser", "--json"),
            *("--workspace", str(workspace.root)),
            *(() if workspace.store is None else ("--store", workspace.store)),
            *arguments,
        ],
        stdout=subprocess.PIPE,
        stderr=events,
        text=True,
        cwd=workspace.root.parent,  # away from the checkout: `-m` would find its package first
        env={**os.environ, "PYTHONUNBUFFERED": "1", **environment},
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line, "the studio ended before it listened"
    return Studio(process, json.loads(line)["url"], workspace)


@pytest.fixture(scope="session")
def studio(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Studio]:
    """One studio that tests share; each brings its own sessions.

    On PostgreSQL where EVASTUDIO_TESTS_ON says so, as `make test-postgres` does.
    """
    store = None
    if os.environ.get("EVASTUDIO_TESTS_ON") == "postgres":
        server: Postgres = request.getfixturevalue("postgres")
        store = server.url(server.create_database())
    running = launch(Workspace(tmp_path_factory.mktemp("shared"), store))
    yield running
    assert running.stop() == 0
