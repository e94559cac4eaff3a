"""Takes: read, thrown away and brought back, and made by the actions of a program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from evastudio.client.connection import NPZ as NPZ_TYPE
from evastudio.client.connection import Connection, packed
from evastudio.client.reading import read

AT_ONCE = 1024
"""Steps that are sent together."""


@dataclass(frozen=True)
class Take:
    """One unbroken demonstration in one world."""

    id: int
    session: int
    number: int
    """Its place in the session, from 1."""
    scene_version: int
    seed: int
    """Of its world; -1 where the world was recorded elsewhere, or goes on from a moment of another.
    """
    options: Mapping[str, float]
    pilot: str
    pairs: int
    seconds: float
    outcome: str | None
    """None while it is being recorded, and where it was broken off."""
    started_at: float
    """Seconds since the epoch."""
    trashed: bool
    note: str
    """What a person noted of it."""


@dataclass(frozen=True)
class Recording:
    """What was recorded in a take."""

    states: NDArray[np.float64]
    """What was perceived at each step, (steps, n)."""
    actions: NDArray[np.float64]
    """What was done then, in the world's frame, (steps, m), or that of all, (steps, characters,
    m)."""
    fixed: Mapping[str, NDArray[Any]]
    """What did not change in the world, each (1, ...)."""
    moving: Mapping[str, NDArray[Any]]
    """What did, each (steps, ...)."""


class TakeInProgress:
    """A take that a program makes by giving its actions; the studio steps the world."""

    def __init__(self, connection: Connection, told: Mapping[str, Any]) -> None:
        self._connection = connection
        self._take_in(told)
        self.id: int = told["take"]

    def act(self, actions: ArrayLike) -> int:
        """Do these actions, one a decision step, (steps, m) or (steps, characters, m); how many
        were done, fewer where the world ended. May be sent again without harm where an answer is
        lost. Raises ConflictError once the take is closed."""
        table = np.asarray(actions, dtype=np.float64)
        done = 0
        for start in range(0, len(table), AT_ONCE):
            part = table[start : start + AT_ONCE]
            content = packed({"first_step": np.array(self.pairs), "actions": part})
            answer = self._connection.send(
                "POST",
                f"/takes/{self.id}/actions",
                headers={"Content-Type": NPZ_TYPE},
                again=True,
                content=content,
            )
            told = answer.json()
            self._take_in(told)
            done += told["accepted"]
            if self.closed:
                break
        return done

    def close(self) -> Take:
        """End it; the take as it is kept."""
        self._take_in(self._connection.post(f"/takes/{self.id}/close"))
        return read(Take, self._connection.get(f"/takes/{self.id}"))

    def _take_in(self, told: Mapping[str, Any]) -> None:
        self.pairs: int = told["pairs"]
        """Steps written so far."""
        self.closed: bool = told["closed"]
        self.outcome: str | None = told["outcome"]
        """How the world ended, or None."""
        self.state = np.asarray(told["state"], dtype=np.float64)
        """What the character perceives now, (n,)."""


class Takes:
    """`studio.takes`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def of(self, session: int, *, trashed: bool | None = None) -> Iterator[Take]:
        """The takes of a session in order: all, or only trashed ones, or only kept ones."""
        told = self._connection.pages(f"/sessions/{session}/takes", trashed=trashed)
        return (read(Take, one) for one in told)

    def get(self, take: int) -> Take:
        """Raises NotFoundError."""
        return read(Take, self._connection.get(f"/takes/{take}"))

    def recording(self, take: int) -> Recording:
        """What was recorded in it."""
        arrays = self._connection.arrays("GET", f"/takes/{take}/recording")
        parts: dict[str, dict[str, NDArray[Any]]] = {"fixed": {}, "moving": {}}
        for name, array in arrays.items():
            part, _, own = name.partition(".")
            if part in parts:
                parts[part][own] = array
        return Recording(arrays["states"], arrays["actions"], **parts)

    def begin(
        self,
        session: int,
        *,
        pilot: str = "program",
        seed: int | None = None,
        options: Mapping[str, float] | None = None,
        perception: str | None = None,
    ) -> TakeInProgress:
        """A new take, in a world of that seed, or of any."""
        body = {"pilot": pilot, "seed": seed, "options": options, "perception": perception}
        given = {name: value for name, value in body.items() if value is not None}
        return TakeInProgress(
            self._connection, self._connection.post(f"/sessions/{session}/takes", given)
        )

    def trash(self, take: int) -> Take:
        """Leave it out until it is restored."""
        return read(Take, self._connection.post(f"/takes/{take}/trash"))

    def restore(self, take: int) -> Take:
        """Bring it back."""
        return read(Take, self._connection.post(f"/takes/{take}/restore"))

    def note(self, take: int, note: str) -> Take:
        """Note something about it, in place of what was noted before."""
        return read(Take, self._connection.put(f"/takes/{take}/note", {"note": note}))

    def empty_trash(self, session: int) -> int:
        """Delete a session's trashed takes for good; how many there were."""
        return int(self._connection.delete(f"/sessions/{session}/trash")["takes"])
