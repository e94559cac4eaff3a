"""Ballots: two runs without names, of which people say which is livelier."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from evastudio.client.connection import Connection
from evastudio.client.lineups import Lineup, lineup
from evastudio.client.reading import read

Livelier = Literal["left", "right", "neither"]


@dataclass(frozen=True)
class Ballot:
    """A question to people. It does not say about whom."""

    id: int
    scene: str
    title: str
    """Of the scene."""
    created_at: float
    """Seconds since the epoch."""
    votes: int
    """Of everybody, those who saw no difference too."""
    mine: int
    """One's own."""


@dataclass(frozen=True)
class Preference:
    """What came of a ballot."""

    ballot: int
    scene: str
    pilots: Sequence[str]
    votes: Sequence[int]
    """For each of them."""
    neither: int
    people: int
    """Who voted, by their tokens."""
    share: float | None
    """Of the votes for one of them, those for the one that has more."""
    interval: Sequence[float] | None
    """95 %, of `share` (Wilson)."""
    says: str


@dataclass(frozen=True)
class Vote:
    """A vote that was cast, and who they were."""

    left: str
    right: str
    livelier: str | None
    """Who that was; None for no difference."""
    preference: Preference
    """What has come of the ballot with this vote."""


class Ballots:
    """`studio.ballots`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Ballot]:
        """Every ballot, the newest first."""
        return self.of()

    def of(self, scene: str | None = None) -> Iterator[Ballot]:
        """Those of one scene where it is given."""
        return (read(Ballot, told) for told in self._connection.pages("/ballots", scene=scene))

    def get(self, ballot: int) -> Ballot:
        """Raises NotFoundError."""
        return read(Ballot, self._connection.get(f"/ballots/{ballot}"))

    def open(
        self,
        scene: str,
        pilots: tuple[str, str],
        *,
        options: Mapping[str, float] | None = None,
        seed: int = 0,
    ) -> Ballot:
        """Ask people which of two pilots is livelier, each time in the next of the worlds that
        follow from the seed."""
        body = {
            "scene": scene,
            "pilots": list(pilots),
            "options": dict(options or {}),
            "seed": seed,
        }
        return read(Ballot, self._connection.post("/ballots", body))

    def show(self, ballot: int) -> Lineup:
        """The two as Left and Right, in the next world that one has not voted on."""
        return lineup(self._connection.post(f"/ballots/{ballot}/showings"))

    def vote(self, ballot: int, shown: Lineup, livelier: Livelier) -> Vote:
        """Say which of the two that were shown was livelier. Raises ConflictError where they are
        no longer open, and where that was said before."""
        body = {"lineup": shown.id, "livelier": livelier}
        told = self._connection.post(f"/ballots/{ballot}/votes", body)
        return read(Vote, told, preference=read(Preference, told["preference"]))

    def preference(self, ballot: int) -> Preference:
        """What came of it so far. Raises ConflictError for a viewer who has not voted on it."""
        return read(Preference, self._connection.get(f"/ballots/{ballot}/preference"))

    def preferences(self) -> Iterator[Preference]:
        """What came of all, the newest first; for viewers of those that they have voted on."""
        return (read(Preference, one) for one in self._connection.pages("/ballots/preferences"))

    def table_three(self) -> str:
        """The paper's table 3, with the studies kept and what came of the ballots, in Markdown."""
        return self._connection.send("GET", "/ballots/table-3").text

    def delete(self, ballot: int) -> None:
        """Forget a ballot and its votes."""
        self._connection.delete(f"/ballots/{ballot}")
