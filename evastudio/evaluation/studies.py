"""Studies of people: how long they were taught, how long they demonstrated, what they preferred.

Nothing is kept of anybody who did not agree to it, and what is kept can be taken back.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import delete, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.rows import put_in
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, NotFoundError


@dataclass(frozen=True)
class Study:
    """One person at one scene, as in the paper's table 3."""

    scene: str
    person: str
    """What they do: 'artist'. No name."""
    instructed_s: float | None
    """How long they were taught; None for somebody who knew the studio."""
    demonstrated_s: float
    preferred: str | None = None
    """The pilot whose way of moving they preferred; None where they were not asked."""

    def __post_init__(self) -> None:
        for name in ("instructed_s", "demonstrated_s"):
            seconds = getattr(self, name)
            if seconds is not None and not 0.0 <= seconds < 1e6:
                raise InvalidInputError(
                    f"{name} of a study is {seconds!r}; give seconds, from 0 on."
                )


@dataclass(frozen=True)
class StudyRecord(Study):
    """A study that is kept."""

    id: int = 0
    created_at: float = 0.0
    """Seconds since the epoch."""


def save_study(store: Store, study: Study, now: float) -> int:
    """Keep `study`; its id. `now` in seconds since the epoch."""
    with writing(store.engine) as connection:
        told = json.dumps(asdict(study), allow_nan=False)
        return put_in(connection, schema.studies, scene=study.scene, created_at=now, told=told)


def replace_study(store: Store, number: int, study: Study) -> None:
    """Keep `study` in place of the one of that id. Raises NotFoundError."""
    table = schema.studies
    told = json.dumps(asdict(study), allow_nan=False)
    with writing(store.engine) as connection:
        done = connection.execute(
            update(table).where(table.c.id == number).values(scene=study.scene, told=told)
        )
    _found(done.rowcount, number)


def forget_study(store: Store, number: int) -> None:
    """Delete a study for good. Raises NotFoundError."""
    table = schema.studies
    with writing(store.engine) as connection:
        done = connection.execute(delete(table).where(table.c.id == number))
    _found(done.rowcount, number)


def studies(store: Store) -> list[Study]:
    """Every study kept, in the order in which they were made."""
    table = schema.studies
    with store.engine.connect() as connection:
        rows = connection.execute(select(table.c.told).order_by(table.c.id)).scalars().all()
    return [Study(**json.loads(told)) for told in rows]


def study_records(
    store: Store, after: int | None = None, limit: int | None = None
) -> Sequence[StudyRecord]:
    """The studies kept and their ids, from the one after `after` on."""
    table = schema.studies
    query = select(table.c.id, table.c.created_at, table.c.told).order_by(table.c.id).limit(limit)
    with store.engine.connect() as connection:
        rows = connection.execute(query.where(table.c.id > (after or 0))).all()
    return [StudyRecord(**json.loads(told), id=number, created_at=at) for number, at, told in rows]


def find_study(store: Store, number: int) -> StudyRecord:
    """Raises NotFoundError."""
    found = study_records(store, after=number - 1, limit=1)
    _found(bool(found) and found[0].id == number, number)
    return found[0]


def _found(there: int, number: int) -> None:
    if not there:
        raise NotFoundError(f"There is no study {number}; it may have been forgotten.")
