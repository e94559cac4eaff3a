"""A PostgreSQL server of the tests' own: started, killed and started again at will."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
import urllib.parse
from pathlib import Path

import psycopg

USER = "studio"
PASSWORD = "a secret: of/the@tests"
READY_S = 30.0
DEBIAN = Path("/usr/lib/postgresql")


class Postgres:
    """A server in a folder of its own, reached through a socket there and from nowhere else."""

    def __init__(self, durable: bool = False) -> None:
        """Make its files; `start` runs it. `durable` writes through to the disk, as tests that
        kill it need; the others are faster without."""
        self.durable = durable
        self.folder = Path(tempfile.mkdtemp(prefix="postgres-"))
        self.account = _account()
        if self.account is not None:
            shutil.chown(self.folder, self.account)
        self.log = self.folder / "log"
        secret = self.folder / "password"
        secret.write_text(PASSWORD)
        secret.chmod(0o644)
        self._run(
            *("initdb", "--pgdata", str(self._data), "--username", USER, "--auth=scram-sha-256"),
            *(f"--pwfile={secret}", "--encoding=UTF8", "--locale=C", "--no-sync"),
        )
        self.process: subprocess.Popen[bytes] | None = None
        self._databases = 0
        self._empty: list[str] = []

    def start(self) -> None:
        """Run the server; returns once it answers."""
        settings = {
            "listen_addresses": "",
            "unix_socket_directories": str(self.folder),
            "fsync": "on" if self.durable else "off",
        }
        given = [part for name, value in settings.items() for part in ("-c", f"{name}={value}")]
        deadline = time.monotonic() + READY_S
        while not self._started(given, deadline):
            # A killed server's processes may take a moment to notice; until then none starts.
            assert time.monotonic() < deadline, self.log.read_text()[-2000:]
            time.sleep(0.1)

    def kill(self) -> None:
        """As `kill -9` does; connections are cut."""
        self._end(signal.SIGKILL)

    def stop(self) -> None:
        """Shut down, cutting connections."""
        self._end(signal.SIGINT)

    def restart(self) -> None:
        """Kill it and start it again."""
        self.kill()
        self.start()

    def remove(self) -> None:
        """Stop it and delete its files."""
        if self.process is not None:
            self.stop()
        shutil.rmtree(self.folder)

    def url(self, database: str = "postgres", password: str = PASSWORD) -> str:
        """The address of a database as `--store` takes it."""
        secret = urllib.parse.quote(password, safe="")
        return f"postgresql+psycopg://{USER}:{secret}@/{database}?host={self.folder}"

    def create_database(self) -> str:
        """An empty database; its name."""
        if self._empty:
            return self._empty.pop()
        self._databases += 1
        name = f"studio_{self._databases}"
        self.execute(f"CREATE DATABASE {name}")
        return name

    def empty_database(self, name: str) -> None:
        """Cut off who still uses a database, and empty it for the next: faster than a new one."""
        self.execute(
            f"SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity WHERE datname = '{name}'"
        )
        self.execute("DROP SCHEMA public CASCADE; CREATE SCHEMA public", name)
        self._empty.append(name)

    def execute(self, statement: str, database: str = "postgres") -> list[tuple[object, ...]]:
        """Run one statement outside any transaction; the rows it gives."""
        with self.connect(database) as connection:
            cursor = connection.execute(statement)  # type: ignore[call-overload]
            return cursor.fetchall() if cursor.description else []

    def connect(self, database: str = "postgres") -> psycopg.Connection[tuple[object, ...]]:
        """A connection past the studio, each statement a transaction of its own."""
        return psycopg.connect(
            host=str(self.folder), user=USER, password=PASSWORD, dbname=database, autocommit=True
        )

    @property
    def _data(self) -> Path:
        return self.folder / "data"

    def _started(self, given: list[str], deadline: float) -> bool:
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [_program("postgres"), "-D", str(self._data), *given],
                stdout=log,
                stderr=log,
                user=self.account,
                group=self.account and pwd.getpwnam(self.account).pw_gid,
                cwd=self.folder,
            )
        while self.process.poll() is None and time.monotonic() < deadline:
            try:
                self.connect().close()
            except psycopg.OperationalError:
                time.sleep(0.02)
            else:
                return True
        return False

    def _end(self, number: signal.Signals) -> None:
        assert self.process is not None
        self.process.send_signal(number)
        self.process.wait(READY_S)
        self.process = None

    def _run(self, program: str, *arguments: str) -> None:
        made = subprocess.run(
            [_program(program), *arguments],
            capture_output=True,
            text=True,
            user=self.account,
            group=self.account and pwd.getpwnam(self.account).pw_gid,
            cwd=self.folder,
        )
        assert made.returncode == 0, made.stderr


def _account() -> str | None:
    """Whom the server runs as: it refuses to be root's. None is oneself."""
    if os.getuid() != 0:
        return None
    known = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in known else "nobody"


def _program(name: str) -> str:
    """The newest Debian has, which are not on its path, or else one on the path."""
    folders = sorted(DEBIAN.glob("*/bin"), key=lambda folder: int(folder.parent.name))
    found = next((f for f in reversed(folders) if (f / name).exists()), None)
    path = str(found / name) if found else shutil.which(name)
    assert path, f"PostgreSQL's {name!r} is not installed; `make postgres` does it."
    return path
