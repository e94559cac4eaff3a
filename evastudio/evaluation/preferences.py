"""Preferences: which of two pilots moves in a livelier way, as people see it who do not know which
is which."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, delete, func, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.rows import newest_first, put_in, row_at
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.evaluation.interval import Interval, wilson_interval


@dataclass(frozen=True)
class Ballot:
    """Two pilots between which people choose."""

    id: int
    scene: str
    created_at: float
    """Seconds since the epoch."""
    pilots: Mapping[str, str | None]
    """The two by name, with the fingerprints of their files."""
    scene_version: int
    options: Mapping[str, float]
    seed: int
    """Of the worlds they are shown in; everybody sees the same ones in the same order."""
    secret: str
    """Decides who stands left; never told."""

    def order(self, voter: str, number: int) -> tuple[int, int]:
        """Which of `pilots` that voter sees left and right when they vote for that time, from 0."""
        told = f"{self.secret} {number} {voter}".encode("utf-8", "surrogatepass")
        left = hashlib.sha256(told).digest()[0] & 1
        return left, 1 - left


@dataclass(frozen=True)
class Preference:
    """What came of a ballot so far."""

    ballot: int
    scene: str
    pilots: tuple[str, str]
    votes: tuple[int, int]
    """For each."""
    neither: int
    """Votes of those who saw no difference."""
    people: int
    """Who voted, by their tokens."""

    @property
    def leading(self) -> int:
        """Which of the two has more votes."""
        return int(self.votes[1] > self.votes[0])

    @property
    def decided(self) -> int:
        return sum(self.votes)

    @property
    def share(self) -> float | None:
        """Of the votes for one of them, those for the leading one; None without any."""
        return self.votes[self.leading] / self.decided if self.decided else None

    @property
    def interval(self) -> Interval | None:
        """95 %, of `share` (Wilson). It takes votes for independent; those of one person are not
        quite."""
        return wilson_interval(self.votes[self.leading], self.decided) if self.decided else None

    @property
    def says(self) -> str:
        """What was found, in words."""
        if self.share is None or self.interval is None:
            return "Nobody has preferred one of them yet."
        ahead, behind = self.pilots[self.leading], self.pilots[1 - self.leading]
        low, high = (f"{100 * end:.0f}" for end in self.interval)
        found = (
            f"{ahead} looked livelier than {behind} in {self.votes[self.leading]} of "
            f"{self.decided} votes: {100 * self.share:.0f} % ({low} to {high} %)."
        )
        if self.interval[0] <= 0.5:
            found += " That can still be chance."
        return found


def open_ballot(
    store: Store,
    scene: Mapping[str, Any],
    pilots: Mapping[str, str | None],
    seed: int,
    now: float,
) -> Ballot:
    """Ask people about two `pilots`, names and fingerprints, in worlds of `scene`, its identity.

    `now` in seconds since the epoch. Raises InvalidInputError where they are not two.
    """
    if len(pilots) != 2:
        raise InvalidInputError(f"{len(pilots)} were named; people choose between two.")
    asked = {
        "pilots": dict(pilots),
        "scene_version": scene["version"],
        "options": dict(scene["options"]),
        "seed": seed,
    }
    with writing(store.engine) as connection:
        made = put_in(
            connection,
            schema.ballots,
            scene=scene["name"],
            created_at=now,
            asked=json.dumps(asked),
            secret=secrets.token_hex(32),
        )
    return find_ballot(store, made)


def ballots(
    store: Store,
    scene: str | None = None,
    *,
    after: int | None = None,
    limit: int | None = None,
) -> list[Ballot]:
    """Every ballot, the newest first; a page of them as of evaluations."""
    query = newest_first(schema.ballots, scene, after, limit)
    with store.engine.connect() as connection:
        return [_ballot(row) for row in connection.execute(query)]


def find_ballot(store: Store, number: int) -> Ballot:
    """Raises NotFoundError."""
    row = row_at(store.engine, schema.ballots, number)
    if row is None:
        raise NotFoundError(f"There is no ballot {number}.")
    return _ballot(row)


def delete_ballot(store: Store, number: int) -> None:
    """Forget a ballot and its votes. Raises NotFoundError."""
    find_ballot(store, number)
    with writing(store.engine) as connection:
        connection.execute(delete(schema.votes).where(schema.votes.c.ballot_id == number))
        connection.execute(delete(schema.ballots).where(schema.ballots.c.id == number))


def votes_of(store: Store, ballot: int, voter: str) -> int:
    """How often somebody has voted."""
    table = schema.votes
    own = (table.c.ballot_id == ballot) & (table.c.voter == voter)
    with store.engine.connect() as connection:
        return int(connection.execute(select(func.count()).where(own)).scalar_one())


def vote(
    store: Store,
    ballot: Ballot,
    voter: str,
    number: int,
    chosen: int | None,
    now: float,
) -> None:
    """Keep what `voter` found of the two when asked for that time: 0, 1, or None for no difference.

    Raises ConflictError where they have voted on that already.
    """
    with writing(store.engine) as connection:
        table = schema.votes
        own = (table.c.ballot_id == ballot.id) & (table.c.voter == voter)
        query = select(table.c.number).where(own, table.c.number == number)
        if connection.execute(query).first() is not None:
            raise ConflictError("You have voted on these two already. Ask for the next ones.")
        connection.execute(
            insert(table).values(
                ballot_id=ballot.id,
                voter=voter,
                number=number,
                created_at=now,
                on_left=ballot.order(voter, number)[0],
                chosen=chosen,
            )
        )


def preference(store: Store, ballot: Ballot) -> Preference:
    """What came of `ballot` so far."""
    table = schema.votes
    of_ballot = table.c.ballot_id == ballot.id
    count = select(table.c.chosen, func.count()).where(of_ballot).group_by(table.c.chosen)
    voters = select(func.count(table.c.voter.distinct())).where(of_ballot)
    with store.engine.connect() as connection:
        found = {chosen: int(many) for chosen, many in connection.execute(count)}
        people = int(connection.execute(voters).scalar_one())
    first, second = ballot.pilots
    return Preference(
        ballot=ballot.id,
        scene=ballot.scene,
        pilots=(first, second),
        votes=(found.get(0, 0), found.get(1, 0)),
        neither=found.get(None, 0),
        people=people,
    )


def preferences(store: Store, some: Sequence[Ballot] | None = None) -> Sequence[Preference]:
    """What came of every ballot on which somebody voted, or of `some`; the oldest first."""
    asked = ballots(store) if some is None else some
    found = (preference(store, ballot) for ballot in sorted(asked, key=lambda one: one.id))
    return [one for one in found if one.people]


def _ballot(row: Row[Any]) -> Ballot:
    asked = json.loads(row.asked)
    return Ballot(
        id=row.id,
        scene=row.scene,
        created_at=row.created_at,
        pilots=asked["pilots"],
        scene_version=asked["scene_version"],
        options=asked["options"],
        seed=asked["seed"],
        secret=row.secret,
    )
