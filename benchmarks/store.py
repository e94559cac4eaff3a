"""Twenty hours of takes in one store, on SQLite and on PostgreSQL; writes docs/store.md.

    python -m benchmarks.store            # some 5 minutes
    python -m benchmarks.store --quick    # a twentieth of the takes, to see that it runs

A scripted demonstrator flies asteroid fields for ten minutes, recorded as a person would be. Those
takes, moments and all, are then written again and again as new ones until the store is full.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
from sqlalchemy import func, insert, select, text

from benchmarks.report import ROOT, commit, where_and_when, write_section
from evastudio.demonstrations import schema
from evastudio.demonstrations.packing import MOVING, pack
from evastudio.demonstrations.store import Store
from evastudio.learning.compiled import ensure_compiled
from evastudio.live import headless
from evastudio.live.perceiving import see_session
from evastudio.workspace import Workspace
from tests.postgres import Postgres

SESSIONS = 10
PAIRS = 108_000
"""Of each session: two hours at 15 decisions a second."""
LEFT_OPEN = 20
"""Every so many takes one was never ended, as by a power cut: its chunks are not joined."""
PAGE = 50
LOADS = 7
OPENS = 15
STARTS = 3
LISTED_MS, LOADED_S, LOADED_PAIRS = 100.0, 1.0, 100_000


@dataclass(frozen=True)
class Found:
    """What was measured of one store; times of wall, seconds."""

    takes: int
    pairs: int
    megabytes: float
    opening: list[float]
    """`Store(url)`, each in a pool of its own."""
    sessions: list[float]
    """A page of sessions with their counts."""
    takes_pages: list[float]
    """A page of takes, every one of every session."""
    over_http: list[float]
    """The same from a running studio."""
    loading: list[float]
    """Every take of a session of 108,000 pairs, moments and all."""
    loading_cpu: list[float]
    unjoined: list[float]
    """The same where no take was ever ended."""
    perceiving: list[float]
    """The same as pairs under the scene's perception, as cleaning and fitting see them."""
    starting: list[float]
    """A studio's process, from its start until it listens."""
    starting_empty: list[float]
    """The same on an empty store."""


def record(folder: Path) -> Workspace:
    """Ten minutes of takes, really recorded."""
    place = Workspace(folder).ready()
    headless.record(place, "asteroids", "scripted:careful", minutes=10.0, seed=1)
    return place


def fill(source: Store, target: Store, pairs: int) -> None:
    """Write the takes of `source` again and again: SESSIONS of `pairs` pairs, one more unjoined."""
    with source.engine.connect() as connection:
        session = connection.execute(select(schema.sessions)).one()._asdict()
        takes = [row._asdict() for row in connection.execute(select(schema.takes))]
        chunks: dict[int, list[dict[str, object]]] = {take["id"]: [] for take in takes}
        for row in connection.execute(select(schema.chunks)):
            chunks[row.take_id].append(row._asdict())
    split = {take["id"]: list(_split(source, take["id"])) for take in takes}
    del session["id"]
    for number in range(SESSIONS + 1):
        whole = number < SESSIONS
        with target.engine.begin() as connection:
            made = insert(schema.sessions).values(**{**session, "name": f"Session {number}"})
            key = connection.execute(made).inserted_primary_key
            assert key is not None
            written = count = 0
            while written < pairs:
                take = dict(takes[count % len(takes)])
                old = take.pop("id")
                count += 1
                ended = whole and count % LEFT_OPEN != 0
                take |= {"session_id": key[0], "number": count, "key": None}
                if not ended:
                    take |= {"ended_at": None, "outcome": None}
                new = connection.execute(insert(schema.takes).values(**take)).inserted_primary_key
                assert new is not None
                rows = chunks[old] if ended else split[old]
                connection.execute(insert(schema.chunks), [{**r, "take_id": new[0]} for r in rows])
                written += sum(int(str(row["steps"])) for row in rows)


def _split(store: Store, take: int) -> Iterator[dict[str, object]]:
    """The chunks of a take as they were while it ran: six steps each."""
    data = store.load_take(take)
    for first in range(0, len(data.actions), 6):
        some = slice(first, first + 6)
        moving = {MOVING + name: array[some] for name, array in data.snapshots.moving.items()}
        arrays = {"states": data.states[some], "actions": data.actions[some], **moving}
        steps = len(data.actions[some])
        yield {"first_step": first, "steps": steps, "arrays": pack(arrays)}


def measure(place: Workspace, empty: Workspace) -> Found:
    """Open, list, page, load and start on the full store of `place`."""
    opening = [_timed(lambda: Store(place.store_url).close()) for _ in range(OPENS)]
    with Store(place.store_url) as store:
        listed = store.sessions()
        unjoined, first = listed[0], listed[-1]
        sessions = [_timed(lambda: store.sessions(limit=PAGE)) for _ in range(OPENS)]
        pages = []
        for session in listed[1:]:
            after: int | None = None
            while True:
                began = time.perf_counter()
                page = store.takes(session.id, None, after=after, limit=PAGE)
                pages.append(time.perf_counter() - began)
                if len(page) < PAGE:
                    break
                after = page[-1].id
        cpu = time.process_time()
        loading = [_timed(lambda: _load(store, first.id)) for _ in range(LOADS)]
        cpu = time.process_time() - cpu
        slow = [_timed(lambda: _load(store, unjoined.id)) for _ in range(3)]
        seen = [_timed(lambda: see_session(place, store, first)[0].pairs()) for _ in range(3)]
        with store.engine.connect() as connection:
            takes = connection.execute(select(func.count()).select_from(schema.takes)).scalar_one()
            stored = connection.execute(select(func.sum(schema.chunks.c.steps))).scalar_one()
            megabytes = _bytes(store, connection) / 1e6
    over_http: list[float] = []
    starting = [_start(place, over_http) for _ in range(STARTS)]
    return Found(
        takes=takes,
        pairs=int(stored),
        megabytes=megabytes,
        opening=opening,
        sessions=sessions,
        takes_pages=pages,
        over_http=over_http,
        loading=loading,
        loading_cpu=[cpu / LOADS],
        unjoined=slow,
        perceiving=seen,
        starting=starting,
        starting_empty=[_start(empty, []) for _ in range(STARTS)],
    )


def _load(store: Store, session: int) -> int:
    takes = store.takes(session)
    return sum(len(data.actions) for data in store.load_takes([take.id for take in takes]))


def _timed(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def _bytes(store: Store, connection: object) -> int:
    if store.url.startswith("sqlite"):
        return Path(store.url.removeprefix("sqlite:///")).stat().st_size
    size = connection.execute(text("SELECT pg_database_size(current_database())"))  # type: ignore[attr-defined]
    return int(size.scalar_one())


def _start(place: Workspace, pages: list[float]) -> float:
    """Seconds until a studio listens; what listing takes then goes to `pages`."""
    began = time.perf_counter()
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "evastudio", "studio", "--port", "0", "--no-browser", "--json"),
            *("--workspace", str(place.root), "--store", place.store_url),
        ],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stdout is not None
    url = json.loads(process.stdout.readline())["url"]
    seconds = time.perf_counter() - began
    base, _, token = url.partition("/?token=")
    headers = {"Authorization": f"Bearer {token}"}
    with httpx.Client(base_url=base, headers=headers, trust_env=False, timeout=30.0) as client:
        listed = client.get("/api/v1/sessions").raise_for_status().json()["items"]
        for session in listed:
            path: str | None = f"/api/v1/sessions/{session['id']}/takes?limit={PAGE}"
            while path:
                sent = time.perf_counter()
                page = client.get(path).raise_for_status().json()
                pages.append(time.perf_counter() - sent)
                after = page.get("next")
                path = (
                    after and f"/api/v1/sessions/{session['id']}/takes?limit={PAGE}&cursor={after}"
                )
    process.terminate()
    process.wait()
    process.stdout.close()
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a twentieth of the takes")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "store.md")
    given = parser.parse_args()
    began = time.perf_counter()
    ensure_compiled()
    pairs = PAIRS // 20 if given.quick else PAIRS
    with tempfile.TemporaryDirectory() as folder:
        recorded = record(Path(folder) / "recorded")
        server = Postgres(durable=True)
        try:
            server.start()
            found, loads = {}, []
            for name in ("SQLite", "PostgreSQL"):
                places = []
                for kind in ("full", "empty"):
                    url = server.url(server.create_database()) if name == "PostgreSQL" else None
                    places.append(Workspace(Path(folder) / f"{name}-{kind}", url).ready())
                full, empty = places
                with Store(recorded.store_url) as source, Store(full.store_url) as target:
                    fill(source, target, pairs)
                    if name == "PostgreSQL":
                        with target.engine.connect() as connection:
                            apart = connection.execution_options(isolation_level="AUTOCOMMIT")
                            apart.execute(text("VACUUM ANALYZE"))
                Store(empty.store_url).close()
                found[name] = measure(full, empty)
                loads.append(os.getloadavg()[1])
                print(name, found[name].pairs, file=sys.stderr)
        finally:
            server.remove()
    told = report(found, time.perf_counter() - began, float(np.mean(loads)))
    print(told)
    write_section(given.out, "store", told)


def report(found: dict[str, Found], seconds: float, waiting: float) -> str:
    """The document."""
    at = commit("evastudio", "benchmarks/store.py")
    sqlite, postgres = found["SQLite"], found["PostgreSQL"]

    def row(what: str, values: Callable[[Found], str], required: str = "") -> str:
        return f"| {what} | {values(sqlite)} | {values(postgres)} | {required} |"

    def p95(values: list[float]) -> str:
        return f"{1000 * np.median(values):.1f} / {1000 * np.quantile(values, 0.95):.1f}"

    def median(values: list[float]) -> str:
        return f"{np.median(values):.2f}"

    each = f"{sqlite.pairs // (SESSIONS + 1):,}"
    return "\n".join(
        [
            "# Twenty hours in one store",
            "",
            "Written by `make bench-store`; do not edit by hand.",
            "",
            where_and_when(at, "python -m benchmarks.store", seconds),
            "",
            f"Takes of a scripted demonstrator, really recorded for ten minutes and then written "
            f"again and again: {SESSIONS} sessions, and one more in which no take was ever ended. "
            f"Of the others one take in {LEFT_OPEN} was not. PostgreSQL runs on the same machine, "
            "reached by a socket, writes through to the disk, and has been vacuumed once. Times "
            f"are of the wall; {waiting:.1f} processes wanted the cores on average, this one among "
            "them.",
            "",
            "| | SQLite | PostgreSQL | required |",
            "|---|---:|---:|---:|",
            row("takes", lambda f: f"{f.takes:,}"),
            row("pairs", lambda f: f"{f.pairs:,}"),
            row("size, MB", lambda f: f"{f.megabytes:,.0f}"),
            row(
                "opening the store, median / p95, ms",
                lambda f: p95(f.opening),
                f"p95 {LISTED_MS:.0f}",
            ),
            row(
                "all sessions with their counts, median / p95, ms",
                lambda f: p95(f.sessions),
                f"p95 {LISTED_MS:.0f}",
            ),
            row(
                f"a page of {PAGE} takes, median / p95, ms",
                lambda f: p95(f.takes_pages),
                f"p95 {LISTED_MS:.0f}",
            ),
            row(
                "the same over HTTP, median / p95, ms",
                lambda f: p95(f.over_http),
                f"p95 {LISTED_MS:.0f}",
            ),
            row(
                f"all pairs of a session of {each}, median, s",
                lambda f: median(f.loading),
                f"{LOADED_S:g} for {LOADED_PAIRS:,}",
            ),
            row("the same, this process's CPU, s", lambda f: median(f.loading_cpu)),
            row("the same where no take was ended, s", lambda f: median(f.unjoined)),
            row("the same as cleaning and fitting see them, s", lambda f: median(f.perceiving)),
            row("a studio's start until it listens, s", lambda f: median(f.starting)),
            row("the same on an empty store, s", lambda f: median(f.starting_empty)),
        ]
    )


if __name__ == "__main__":
    main()
