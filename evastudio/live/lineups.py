"""The lineups of a server: flown, opened, found and closed by name."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.demonstrations.store import Store
from evastudio.errors import BusyError, ConflictError, InvalidInputError, not_found
from evastudio.evaluation.blaming import blaming
from evastudio.live.headless import make_scene
from evastudio.live.lineup import Column, Lineup, Ran
from evastudio.live.piloting import load_pilot
from evastudio.live.reel import Reel
from evastudio.pilots.again import AgainPilot
from evastudio.pilots.lead import LeadPilot
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

FEWEST, MOST = 2, 4
MOST_WORLDS = 100_000
"""Of one series of worlds."""
LONGEST_S = 60.0
"""So much of a run is shown at most."""
MOST_OPEN = 24
MOST_OF_ONE = 3
"""Open of one person; of more the oldest is closed."""
MOST_BYTES = 2 * 2**30
"""Of the runs of all that are open."""
PATIENCE_S = 60.0
"""So long one waits for others whose lineups are being flown."""
SIDES = ("Left", "Right")
"""What the two of a ballot are called until somebody has voted."""
IDLE_S = 60.0
"""A lineup that nobody looks at this long is closed."""


@dataclass(frozen=True)
class Entrant:
    """Somebody in a lineup: a pilot, or a take as it was recorded."""

    pilot: str | None = None
    """A policy's name, or that of a program."""
    take: int | None = None

    def __post_init__(self) -> None:
        if (self.pilot is None) is (self.take is None):
            raise InvalidInputError("Name a pilot or a take for each that is shown, not both.")


@dataclass(frozen=True)
class World:
    """Which world of which scene."""

    scene: str
    options: Mapping[str, float]
    seed: int
    """Of the series of worlds."""
    number: int = 0
    """Which of the series, from 0."""

    def __post_init__(self) -> None:
        if not 0 <= self.number < MOST_WORLDS:
            raise InvalidInputError(f"World {self.number} is none from 0 to {MOST_WORLDS - 1}.")

    @property
    def own_seed(self) -> int:
        return world_seeds(self.seed, self.number + 1)[-1]


@dataclass(frozen=True)
class Opened:
    """A lineup that is open."""

    lineup: Lineup
    owner: str
    """Whose it is; nobody else finds it."""
    world: World
    ballot: int | None = None
    """The one that it is shown for."""
    order: tuple[int, ...] = ()
    """Which of the ballot's pilots is in each column."""


class Lineups:
    """The lineups of a server. Safe to use from several threads."""

    def __init__(self, workspace: Workspace, store: Store) -> None:
        self._workspace = workspace
        self._store = store
        self._open: dict[str, Opened] = {}
        self._lock = threading.Lock()
        self._flying = threading.Lock()

    def open(self, owner: str, world: World, entrants: Sequence[Entrant]) -> Opened:
        """Fly `entrants` through `world`, or where there are takes through that of the first take.

        Raises InvalidInputError, NotFoundError, ConflictError where takes are of different worlds,
        BusyError where too many are open or being flown.
        """
        if not FEWEST <= len(entrants) <= MOST:
            raise InvalidInputError(
                f"{len(entrants)} were named; side by side are shown {FEWEST} to {MOST}."
            )
        lineup = _lineup(self._fly(world, entrants), ways=True)
        return self._admit(Opened(lineup, owner, world))

    def open_blind(
        self, owner: str, world: World, pilots: Sequence[str], ballot: int, order: Sequence[int]
    ) -> Opened:
        """Two of them for a ballot, in `order`, with nothing that tells who is who."""
        runs = self._fly(world, [Entrant(pilots[which]) for which in order])
        unnamed = [replace(ran, title=side) for ran, side in zip(runs, SIDES, strict=True)]
        lineup = _lineup(unnamed, ways=False)
        return self._admit(Opened(lineup, owner, world, ballot, tuple(order)))

    def get(self, owner: str, name: str) -> Opened:
        """Raises NotFoundError."""
        with self._lock:
            found = self._open.get(name)
        if found is None or found.owner != owner:
            raise not_found("lineup", name, [])
        return found

    def all(self, owner: str) -> list[Opened]:
        """Those of one person, the first opened first."""
        with self._lock:
            return [one for one in self._open.values() if one.owner == owner]

    def column(self, name: str) -> tuple[Opened, Column] | None:
        """The column whose view has that name."""
        with self._lock:
            everything = list(self._open.values())
        for one in everything:
            for column in one.lineup.columns:
                if column.name == name:
                    return one, column
        return None

    def close(self, name: str) -> None:
        """Close a lineup, if it is open."""
        with self._lock:
            found = self._open.pop(name, None)
        if found is not None:
            found.lineup.close()

    def close_all(self) -> None:
        with self._lock:
            names = list(self._open)
        for name in names:
            self.close(name)

    def _admit(self, opened: Opened) -> Opened:
        with self._lock:
            own = [name for name, one in self._open.items() if one.owner == opened.owner]
            going = own[: max(0, len(own) + 1 - MOST_OF_ONE)]
            staying = [one.lineup for name, one in self._open.items() if name not in going]
            held = opened.lineup.bytes + sum(lineup.bytes for lineup in staying)
            full = len(staying) >= MOST_OPEN or held > MOST_BYTES
            if not full:
                self._open[opened.lineup.name] = opened
        if full:
            opened.lineup.close()
            raise BusyError(f"{len(staying)} lineups are open already; try again in a minute.")
        for name in going:
            self.close(name)
        return opened

    def _fly(self, world: World, entrants: Sequence[Entrant]) -> list[Ran]:
        """What each does from the same moment on. One lineup is flown at a time: it takes all of a
        processor, which live stages share."""
        if not self._flying.acquire(timeout=PATIENCE_S):
            raise BusyError("Others are being flown side by side; try again in a minute.")
        try:
            takes = [None if one.take is None else self._take(one.take) for one in entrants]
            given = [one for one in takes if one is not None]
            if given:
                first = given[0]
                for other in given[1:]:
                    first.check_same(other)
                scene, start, seed, others = first.scene, first.start, first.seed, first.others
            else:
                scene = make_scene(self._workspace, world.scene, world.options)
                seed, others = world.own_seed, None
                start = scene.worlds([seed])
            pilots = [
                None if one.pilot is None else load_pilot(self._workspace, one.pilot, scene)
                for one in entrants
            ]
            runs = []
            for entrant, take, pilot in zip(entrants, takes, pilots, strict=True):
                if take is not None:
                    runs.append(take.ran)
                elif pilot is not None:
                    name = str(entrant.pilot)
                    who = pilot if others is None else LeadPilot(pilot, others)
                    with blaming(scene, name):
                        runs.append(Ran(name, flown(scene, who, seed, start)))
            return runs
        finally:
            self._flying.release()

    def _take(self, number: int) -> _Take:
        record = self._store.take(number)
        session = self._store.session(record.session)
        scene = make_scene(self._workspace, session.scene, record.options)
        if scene.version != record.scene_version:
            raise ConflictError(
                f"Take {record.number} of {session.name!r} is of version {record.scene_version} of "
                f"its scene, and this is version {scene.version}. Choose a newer take."
            )
        data = self._store.load_take(number)
        title = f"Take {record.number} of {session.name}"
        return _Take(
            scene=scene,
            ran=Ran(title, Reel.of_take(scene, record, data)),
            start=data.snapshots.take(slice(0, 1)),
            seed=0 if record.seed == RECORDED else record.seed,
            others=AgainPilot(data.actions) if scene.characters else None,
        )


def _lineup(runs: Sequence[Ran], ways: bool) -> Lineup:
    """A lineup of `runs`. Raises InvalidInputError where their scene fails while it is looked at,
    and where one is so large that its beginning is forgotten."""
    for ran in runs:
        if ran.reel.first:
            raise InvalidInputError(
                f"{ran.title} is too large to be shown side by side: it fills "
                f"{ran.reel.bytes / 2**20:,.0f} MB and more. Choose fewer characters or a shorter "
                "take."
            )
    with blaming(runs[0].reel.scene, runs[0].title):
        return Lineup(secrets.token_hex(6), runs, ways=ways)


@dataclass(frozen=True)
class _Take:
    """A take to be shown, and what others need to do the same in its world."""

    scene: Scene
    ran: Ran
    start: Snapshot
    seed: int
    others: Pilot | None
    """What everybody else did; None where one character acts alone."""

    def check_same(self, other: _Take) -> None:
        """Raises ConflictError where `other` began elsewhere."""
        same = self.scene.identity() == other.scene.identity() and all(
            (self.start[name] == other.start[name]).all()
            for arrays in (self.start.fixed, self.start.moving)
            for name in arrays
        )
        if not same:
            raise ConflictError(
                f"{self.ran.title} and {other.ran.title} begin in different worlds, so they cannot "
                "be shown side by side. Choose takes made in the same world (Shift R)."
            )


def flown(scene: Scene, pilot: Pilot, seed: int, start: Snapshot) -> Reel:
    """What `pilot` does from `start`, a moment of one world of that seed, until its end.

    At most LONGEST_S of it.
    """
    reel = Reel(scene, Origin(0, policy=pilot.name, seed=seed))
    done: list[Array] = []

    def watch(_: object, snapshot: Snapshot, actions: Array) -> None:
        reel.add(snapshot)
        done.append(actions)

    most = max(1, round(LONGEST_S / scene.dt_s))
    roll_out(scene, pilot, [seed], start=start, max_steps=most, watcher=watch)
    reel.add(scene.step(reel.moment(reel.last), done[-1]))
    return reel
