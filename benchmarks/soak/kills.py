"""Does `kill -9` at any moment cost more than half a second of a take, or anything else?

    python -m benchmarks.soak --only kills            # 200 kills on each store, some 25 minutes
    python -m benchmarks.soak --only kills --quick    # 8 rounds on each

In every round pages demonstrate at a studio while a program cleans, fits and saves; studio and
program are killed at a random moment, on PostgreSQL sometimes the database too. The next studio
opens the store as it is, and what is there is held against what the pages had been told.
"""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sqlite3
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import httpx
import numpy as np

from benchmarks.report import ROOT, commit, where_and_when, write_section
from benchmarks.soak.flights import HEADERS, WAIT_S, Flight
from benchmarks.soak.nursery import SESSION, Child, Nursery
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.errors import StudioError
from evastudio.learning.policy_files import load_policy
from evastudio.live import headless
from evastudio.workspace import Workspace
from tests.postgres import Postgres

ROUNDS, QUICK = 220, 8
STAGES = 4
LOSS_S = 0.5
END_S = 5.0
"""What is allowed: of a take lost, and from SIGTERM to the end."""
MOMENT_S = (0.02, 2.5)
"""When the studio is killed, after the first take began."""
TERMINATED = 11
"""Of so many rounds one ends by SIGTERM instead."""
KINDS = {
    "sqlite": {"studio": 0.8, "studio, store locked": 0.2},
    "postgresql": {"studio": 0.5, "database, later studio": 0.25, "database and studio": 0.25},
}


@dataclass
class Found:
    """What rounds of one kind led to."""

    rounds: int = 0
    takes: int = 0
    lost_s: list[float] = field(default_factory=list)
    """Of each take: what was told of, and is not there."""
    policies: int = 0
    half: int = 0
    """Policies that do not load."""
    leftovers: int = 0
    """Files that were being written, under names that nobody takes for policies."""
    saved_s: list[float] = field(default_factory=list)
    """From the next start until nothing waits in files."""
    ended_s: list[float] = field(default_factory=list)
    """From SIGTERM to the end of the process."""
    wrong: list[str] = field(default_factory=list)


class Rounds:
    """Rounds on one store, each a studio that is begun, used and killed."""

    def __init__(
        self, store: str, workspace: Workspace, nursery: Nursery, postgres: Postgres | None
    ) -> None:
        self.store = store
        self.workspace = workspace
        self.nursery = nursery
        self.postgres = postgres
        self.found: dict[str, Found] = defaultdict(Found)
        self._unsaved = workspace.unsaved[0]
        self._scene = headless.make_scene(workspace, "asteroids", {"density": 0.5})

    def run(self, rounds: int, seed: int) -> None:
        headless.record(self.workspace, "asteroids", minutes=0.5, session=SESSION)
        studio = self.nursery.studio(self.workspace)
        for number in range(rounds):
            rng = np.random.default_rng([seed, len(self.store), number])
            kinds = KINDS[self.store]
            kind = str(rng.choice(list(kinds), p=list(kinds.values())))
            moment_s = float(rng.uniform(*MOMENT_S))
            terminated = number % TERMINATED == TERMINATED // 2
            found = self.found["SIGTERM: " + kind if terminated else kind]
            with Store(self.workspace.store_url) as store:
                flights = [
                    Flight(
                        store.create_session(self._scene, f"{number}.{stage}", "soak", time.time()),
                        restarts=stage % 2 == 1,
                    )
                    for stage in range(STAGES)
                ]
            saver = self.nursery.saver(self.workspace)
            number_ended = signal.SIGTERM if terminated else signal.SIGKILL
            playing = _play(self, studio, saver, flights, kind, moment_s, number_ended, rng)
            ended_s = asyncio.run(playing)
            if terminated:
                found.ended_s.append(ended_s)
            if self.postgres is not None and self.postgres.process is None:
                self.postgres.start()
            waiting = [file for file in self._unsaved.glob("*") if file.stat().st_size]
            studio = self.nursery.studio(self.workspace)
            before = len(found.wrong)
            self._await_rescue(waiting, found)
            self._check(flights, found, terminated)
            told = f"{self.store} round {number}: {kind}, {number_ended.name} {moment_s:.3f} s on"
            print(told, *found.wrong[before:], sep="\n  ", flush=True)
        studio.end(signal.SIGKILL)

    def _await_rescue(self, waiting: list[Path], found: Found) -> None:
        """Return when the new studio has saved what the killed one left in files."""
        began = time.monotonic()
        while any(path.exists() for path in waiting):
            if time.monotonic() - began > WAIT_S:
                found.wrong.append(f"takes still wait to be saved after {WAIT_S:g} s")
                return
            time.sleep(0.05)
        found.saved_s.append(time.monotonic() - began)

    def _check(self, flights: list[Flight], found: Found, terminated: bool) -> None:
        """Hold what is in the store and the folder against what was told."""
        found.rounds += 1
        try:
            with Store(self.workspace.store_url) as store:
                for flight in flights:
                    self._check_takes(store, flight, found, terminated)
                session = store.session(SESSION)
                pairs = {take.id: take.pairs for take in store.takes(session.id)}
                marks = {take: len(mask) for take, mask in store.marks(session.id).items()}
                if marks and marks != pairs:
                    found.wrong.append(f"the cleaning has marks for {marks}, the takes are {pairs}")
        except StudioError as error:
            found.wrong.append(str(error))
        for path in self.workspace.policies.iterdir():
            if path.suffix != ".safetensors":
                found.leftovers += 1
                path.unlink()
                continue
            found.policies += 1
            try:
                load_policy(path)
            except StudioError as error:
                found.half += 1
                found.wrong.append(str(error))

    def _check_takes(self, store: Store, flight: Flight, found: Found, terminated: bool) -> None:
        takes = store.takes(flight.session, trashed=None)
        unseen = 1 if terminated else 0  # begun after the page was sent away
        if len(takes) > len(flight.told) + unseen:
            found.wrong.append(f"{len(takes)} takes, of {len(flight.told)} was told")
        kept = {take.seed: take.pairs for take in takes}
        for place, (seed, told) in enumerate(flight.told.items()):
            pairs = kept.get(seed, 0)
            lost_s = (told - pairs) * self._scene.dt_s
            found.takes += 1
            found.lost_s.append(max(0.0, lost_s))
            if lost_s > LOSS_S:
                found.wrong.append(
                    f"take {place + 1} of session {flight.session} has {pairs} pairs of {told}: "
                    f"told of {flight.told}, kept are {kept}"
                )
        for take in takes:
            data = store.load_take(take.id)
            replayed = replay_take(self._scene, take, data)
            whole = len(data.actions) == take.pairs and all(
                np.array_equal(replayed[name], data.snapshots[name])
                for name in data.snapshots.moving
            )
            if not whole:
                found.wrong.append(f"take {take.id} does not replay")


async def _play(
    rounds: Rounds,
    studio: Child,
    saver: Child,
    flights: list[Flight],
    kind: str,
    moment_s: float,
    number: signal.Signals,
    rng: np.random.Generator,
) -> float:
    """Fly until everything is killed as `kind` says; the seconds the studio took to end."""
    flying = [
        asyncio.create_task(flight.fly(studio, int(rng.integers(2**31)))) for flight in flights
    ]
    begun = asyncio.create_task(flights[0].recording.wait())
    await asyncio.wait([begun, *flying], timeout=WAIT_S, return_when=asyncio.FIRST_COMPLETED)
    if not begun.done():
        begun.cancel()
        for flight in flying:
            flight.cancel()
        failed = await asyncio.gather(*flying, return_exceptions=True)
        raise AssertionError(f"no page could demonstrate: {failed}")
    if number is signal.SIGTERM:  # a job runs, too
        address = f"{studio.url}/api/v1/sessions/1/tune"
        asked = partial(httpx.post, json={}, headers=HEADERS, trust_env=False, timeout=WAIT_S)
        await asyncio.to_thread(asked, address)
    await asyncio.sleep(moment_s)
    postgres = rounds.postgres
    locking = contextlib.nullcontext()
    if kind == "studio, store locked":
        locking = _locked(rounds.workspace.root / "studio.db")
    with locking:
        if "locked" in kind:
            await asyncio.sleep(rng.uniform(0.0, 1.0))
        elif kind.startswith("database"):
            assert postgres is not None
            postgres.kill()
            await asyncio.sleep(rng.uniform(0.0, 1.0))
            if kind == "database, later studio":
                await asyncio.to_thread(postgres.start)
                await asyncio.sleep(rng.uniform(0.0, 1.0))
        saver.end(signal.SIGKILL)
        ended_s = await asyncio.to_thread(studio.end, number)
    await asyncio.gather(*flying)
    return ended_s


@contextlib.contextmanager
def _locked(file: Path) -> Iterator[None]:
    """While another program has the store to itself."""
    other = sqlite3.connect(file, isolation_level=None, timeout=30.0)
    other.execute("begin exclusive")
    try:
        yield
    finally:
        other.close()


def table(all_rounds: list[Rounds]) -> list[str]:
    lines = [
        "| store | killed | rounds | takes | lost of a take, most (median) | wrong | "
        "policies read | half-written | saved after the start, at most | ended after, at most |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for rounds in all_rounds:
        for kind, found in sorted(rounds.found.items()):
            lost = f"{max(found.lost_s):.2f} s ({statistics.median(found.lost_s):.2f} s)"
            ended = f"{max(found.ended_s):.1f} s" if found.ended_s else ""
            lines.append(
                f"| {rounds.store} | {kind} | {found.rounds} | {found.takes} | {lost} | "
                f"{len(found.wrong)} | {found.policies} | {found.half} | "
                f"{max(found.saved_s, default=0.0):.1f} s | {ended} |"
            )
    return lines


def run(quick: bool, seed: int) -> bool:
    began = time.monotonic()
    count = QUICK if quick else ROUNDS
    log = Path(tempfile.gettempdir()) / "evastudio-kills.log"
    print(f"What studios complain of goes to {log}.")
    postgres = Postgres(durable=True)
    with Nursery(log) as nursery, tempfile.TemporaryDirectory() as folder:
        try:
            postgres.start()
            address = postgres.url(postgres.create_database())
            here = Workspace(Path(folder) / "sqlite").ready()
            there = Workspace(Path(folder) / "postgresql", address).ready()
            done = [
                Rounds("sqlite", here, nursery, None),
                Rounds("postgresql", there, nursery, postgres),
            ]
            with ThreadPoolExecutor(len(done)) as beside:  # a round mostly waits
                list(beside.map(lambda rounds: rounds.run(count, seed), done))
        finally:
            postgres.remove()
    lines = table(done)
    print(*lines, sep="\n")
    every = [found for rounds in done for found in rounds.found.values()]
    held = not any(found.wrong for found in every)
    held &= all(seconds <= END_S for found in every for seconds in found.ended_s)
    if not quick:
        at = commit("evastudio", "benchmarks/soak")
        command = f"python -m benchmarks.soak --only kills --seed {seed}"
        told = [where_and_when(at, command, time.monotonic() - began), "", *lines]
        write_section(ROOT / "docs" / "reliability.md", "killed", "\n".join(told))
    return held
