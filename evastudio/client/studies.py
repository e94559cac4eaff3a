"""Studies of people, as in the paper's table 3, kept where somebody agreed to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from evastudio.client.connection import Connection
from evastudio.client.reading import read


@dataclass(frozen=True)
class Study:
    """How long somebody was taught and demonstrated."""

    id: int
    created_at: float
    """Seconds since the epoch."""
    scene: str
    person: str
    """What they do; no name."""
    instructed_s: float | None
    demonstrated_s: float
    """Of the kept takes of their session."""
    preferred: str | None


class Studies:
    """`studio.studies`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Study]:
        """The studies kept, in the order in which they were made."""
        return (read(Study, told) for told in self._connection.pages("/studies"))

    def keep(
        self,
        session: int,
        person: str,
        *,
        instructed_s: float | None = None,
        preferred: str | None = None,
    ) -> Study:
        """Keep how long somebody who agreed was taught and, from the takes of a session, how long
        they demonstrated; `person` is what they do ('artist'), no name."""
        body = _body(session, person, instructed_s, preferred)
        return read(Study, self._connection.post("/studies", body))

    def replace(
        self,
        study: int,
        session: int,
        person: str,
        *,
        instructed_s: float | None = None,
        preferred: str | None = None,
    ) -> Study:
        """The same of the same person once more, after they demonstrated further."""
        body = _body(session, person, instructed_s, preferred)
        return read(Study, self._connection.put(f"/studies/{study}", body))

    def forget(self, study: int) -> None:
        """Delete it for good, as the person may want who agreed to it."""
        self._connection.delete(f"/studies/{study}")


def _body(
    session: int, person: str, instructed_s: float | None, preferred: str | None
) -> Mapping[str, Any]:
    return {
        "session": session,
        "person": person,
        "instructed_s": instructed_s,
        "preferred": preferred,
    }
