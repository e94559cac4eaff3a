"""Sessions, and the work on them: cleaning, fitting, tuning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from evastudio.client.connection import Connection
from evastudio.client.jobs import Job
from evastudio.client.reading import read
from evastudio.errors import NotFoundError

Delay = float | Literal["auto", "off"]
"""Reaction delay to take out: as estimated where that helps, none, or so many seconds."""


Verdict = Literal["keep", "delete", "missing"]
"""What is said of a pair: it was meant, it was a mistake, or it was meant and the perception does
not show what tells it from the others."""


@dataclass(frozen=True)
class Cleaning:
    """The cleaning in force for a session."""

    pairs: int
    """Pairs that were looked at."""
    removed: int
    """Pairs marked as conflicts."""
    stale: bool
    """Takes were added, trashed or restored since."""
    created_at: float
    """Seconds since the epoch."""
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class Session:
    """The takes one demonstrator made of one scene for one purpose."""

    id: int
    name: str
    scene: str
    scene_version: int
    demonstrator: str
    created_at: float
    """Seconds since the epoch."""
    takes_kept: int
    takes_trashed: int
    pairs: int
    """Of the kept takes."""
    seconds: float
    cleaning: Cleaning | None


@dataclass(frozen=True)
class Pairs:
    """The pairs of a session, as learners see them."""

    states: NDArray[np.float64]
    """(pairs, n)"""
    actions: NDArray[np.float64]
    """In the character's own frame, (pairs, m)."""
    takes: NDArray[np.int64]
    """The take of each, (pairs,)."""
    steps: NDArray[np.int64]
    """Its step there, (pairs,)."""
    conflicts: NDArray[np.bool_]
    """Whether cleaning marked it, (pairs,)."""
    corrections: NDArray[np.bool_]
    """Whether somebody showed it who had taken over from a policy, (pairs,)."""


@dataclass(frozen=True)
class Conflict:
    """A pair that conflicts with others, or that something was said of."""

    take: int
    number: int
    """Of the take in its session, from 1."""
    step: int
    seconds: float
    """When in its take, of the moment that the action answered."""
    says: str
    """What is odd about it, for its demonstrator."""
    action: Mapping[str, float]
    """In the character's own frame; a symbol as {its name: 1}."""
    usual: Mapping[str, float]
    """The median of what was done in moments like it."""
    deviation: float
    """How far it is off, as a share of the range."""
    limit: float
    conflict: bool
    """Whether it is farther off than the limit."""
    verdict: Verdict | None
    goes: bool
    """Whether cleaning would leave it out."""


@dataclass(frozen=True)
class Conflicts:
    """What cleaning would leave out."""

    pairs: int
    conflicts: int
    goes: int
    """Pairs that cleaning would leave out, what was said of single ones included."""
    limit: float
    """The middle of the limits."""
    perception: str
    neighbors: int
    """Moments that each pair is compared with."""
    symbols: bool
    stale: bool
    """Takes were added, thrown away or brought back since the look: look again."""
    items: Sequence[Conflict]
    """Conflicts, and pairs that something was said of, the farthest off first."""


class Sessions:
    """`studio.sessions`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Session]:
        """All sessions, newest first."""
        return self.of()

    def of(self, scene: str | None = None) -> Iterator[Session]:
        """Sessions, newest first; those of one scene where it is given."""
        return (_session(told) for told in self._connection.pages("/sessions", scene=scene))

    def get(self, session: int) -> Session:
        """Raises NotFoundError."""
        return _session(self._connection.get(f"/sessions/{session}"))

    def create(self, scene: str, name: str, demonstrator: str = "program") -> Session:
        """A new, empty session. Raises NotFoundError for a scene that there is not."""
        body = {"scene": scene, "name": name, "demonstrator": demonstrator}
        return _session(self._connection.post("/sessions", body))

    def record(
        self,
        scene: str,
        pilot: str = "scripted:careful",
        *,
        minutes: float = 8.0,
        seed: int = 0,
        options: Mapping[str, float] | None = None,
        name: str | None = None,
    ) -> Job:
        """Let a scripted demonstrator record a new session; a job whose result names it."""
        body = {
            "scene": scene,
            "pilot": pilot,
            "minutes": minutes,
            "seed": seed,
            "options": dict(options or {}),
            **({} if name is None else {"session": name}),
        }
        return read(Job, self._connection.post("/demonstrations", body))

    def pairs(self, session: int, *, perception: str | None = None) -> Pairs:
        """The pairs of the kept takes, as a perception shows them."""
        found = self._connection.arrays("GET", f"/sessions/{session}/pairs", perception=perception)
        return read(Pairs, found)

    def clean(
        self,
        session: int,
        *,
        perception: str | None = None,
        n_neighbors: int | None = None,
        threshold: float | Literal["auto"] | None = None,
        delay: Delay = "auto",
    ) -> Job:
        """Mark the conflicts among the kept pairs; a job."""
        return self._work(
            session,
            "clean",
            perception=perception,
            n_neighbors=n_neighbors,
            threshold=threshold,
            delay=delay,
        )

    def preview_cleaning(
        self,
        session: int,
        *,
        perception: str | None = None,
        n_neighbors: int | None = None,
        threshold: float | Literal["auto"] | None = None,
        delay: Delay = "auto",
        worst: int | None = None,
    ) -> Job:
        """What cleaning would mark, the `worst` told in full; a job, and nothing is kept."""
        return self._work(
            session,
            "clean/preview",
            perception=perception,
            n_neighbors=n_neighbors,
            threshold=threshold,
            delay=delay,
            worst=worst,
        )

    def conflicts(
        self, session: int, *, threshold: float | Literal["auto"] = "auto", limit: int = 50
    ) -> Conflicts:
        """What cleaning at that threshold would leave out, by what `preview_cleaning` found last.

        Raises NotFoundError where nobody has looked.
        """
        told = self._connection.get(
            f"/sessions/{session}/conflicts", threshold=threshold, limit=limit
        )
        if told is None:
            raise NotFoundError(
                f"Conflicts have not been looked for in session {session} so far. Look first."
            )
        return read(Conflicts, told, items=[read(Conflict, one) for one in told["items"]])

    def judge(self, session: int, take: int, step: int, verdict: Verdict | None) -> None:
        """Say of a pair what cleanings to come are to make of it; None withdraws it."""
        path = f"/sessions/{session}/verdicts/{take}/{step}"
        if verdict is None:
            self._connection.delete(path)
        else:
            self._connection.put(path, {"verdict": verdict})

    def undo_cleaning(self, session: int) -> Session:
        """Take the latest cleaning back."""
        return _session(self._connection.delete(f"/sessions/{session}/clean"))

    def fit(
        self,
        session: int,
        *,
        name: str | None = None,
        learner: str | None = None,
        perception: str | None = None,
        settings: Mapping[str, Any] | None = None,
        delay: Delay = "auto",
    ) -> Job:
        """Fit a policy to the kept pairs, without marked conflicts; a job whose result names it.

        Without a `name` no policy is replaced by another: the new one gets a number.
        """
        return self._work(
            session,
            "fit",
            name=name,
            learner=learner,
            perception=perception,
            settings=None if settings is None else dict(settings),
            delay=delay,
        )

    def tune(
        self, session: int, *, learner: str | None = None, perception: str | None = None
    ) -> Job:
        """Try learners and settings on takes held out; a job whose result is the report."""
        return self._work(session, "tune", learner=learner, perception=perception)

    def diagnose(
        self, session: int, *, perception: str | None = None, delay: Delay = "auto"
    ) -> Job:
        """Look for what would keep a policy from learning; a job."""
        return self._work(session, "diagnose", perception=perception, delay=delay)

    def _work(self, session: int, work: str, **body: Any) -> Job:
        given = {name: value for name, value in body.items() if value is not None}
        return read(Job, self._connection.post(f"/sessions/{session}/{work}", given))


def _session(told: Mapping[str, Any]) -> Session:
    cleaning = told["cleaning"]
    return read(Session, told, cleaning=None if cleaning is None else read(Cleaning, cleaning))
