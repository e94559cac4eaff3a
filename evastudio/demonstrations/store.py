"""The session store: takes are written while they happen and never deleted unasked."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from sqlalchemy import Connection, delete, func, insert, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.chunks import Part, join_chunks, no_take, write_chunks
from evastudio.demonstrations.cleanings import delete_cleaning, read_marks, write_cleaning
from evastudio.demonstrations.contents import read_takes
from evastudio.demonstrations.engine import open_engine, writing
from evastudio.demonstrations.gathering import Gathering
from evastudio.demonstrations.names import checked_name, checked_note
from evastudio.demonstrations.packing import MOVING, pack
from evastudio.demonstrations.records import (
    Marks,
    NewTake,
    Origin,
    SessionRecord,
    TakeData,
    TakeRecord,
    Verdict,
    Verdicts,
)
from evastudio.demonstrations.rows import LARGEST_ID, newest_first, put_in
from evastudio.demonstrations.summaries import (
    session_records,
    take_record,
    takes_query,
)
from evastudio.demonstrations.verdicts import read_verdicts, write_verdict
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray

TAKES_READ = 16
"""Takes read at once: a session of many is not in memory twice."""
TOGETHER = 1000
"""Rows named in one statement."""


class Store:
    """Sessions, their takes and cleanings, in one database. Safe to use from several threads."""

    def __init__(self, url: str) -> None:
        """Open or make the store at the SQLAlchemy URL `url`. Raises StorageError."""
        self.url = url
        self.engine = open_engine(url)
        """Of the database, for what else is kept in it."""
        self._gathering = Gathering(self.engine, write_chunks)
        with self.engine.connect() as connection:
            self.identity: str = connection.execute(select(schema.store.c.identity)).scalar_one()

    def close(self) -> None:
        self.engine.dispose()

    def ask(self) -> None:
        """Ask it anything. Raises StorageError where it does not answer."""
        with self.engine.connect() as connection:
            connection.execute(select(schema.store.c.version)).scalar_one()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- sessions ------------------------------------------------------------------------------

    def create_session(
        self, scene: Scene, name: str, demonstrator: str, now: float, made_by: str = ""
    ) -> int:
        """A new, empty session; its id. `now` in seconds since the epoch."""
        values = {
            "name": checked_name(name, "session"),
            "scene": scene.name,
            "scene_version": scene.version,
            "demonstrator": checked_name(demonstrator, "demonstrator"),
            "created_at": now,
            "made_by": made_by,
        }
        with writing(self.engine) as connection:
            return put_in(connection, schema.sessions, **values)

    def sessions(
        self, scene: str | None = None, *, after: int | None = None, limit: int | None = None
    ) -> list[SessionRecord]:
        """All sessions, newest first; those of one scene where `scene` is given.

        A page of them: at most `limit`, from the one that follows the session `after`.
        """
        query = newest_first(schema.sessions, scene, after, limit)
        with self.engine.connect() as connection:
            return session_records(connection, query)

    def session(self, reference: int | str) -> SessionRecord:
        """The session with that id, or else that name. Raises NotFoundError.

        Of several sessions of one name it is the newest.
        """
        table = schema.sessions
        with self.engine.connect() as connection:
            found: list[SessionRecord] = []
            if str(reference).isdecimal() and int(reference) <= LARGEST_ID:
                found = session_records(
                    connection, select(table).where(table.c.id == int(reference))
                )
            if not found:
                named = select(table).where(table.c.name == str(reference))
                found = session_records(connection, named.order_by(table.c.id.desc()).limit(1))
        if not found:
            raise NotFoundError(
                f"There is no session {str(reference)!r}; `evastudio sessions` lists them."
            )
        return found[0]

    def count_sessions(self, scene: str) -> int:
        """How many sessions of a scene there are."""
        query = select(func.count()).where(schema.sessions.c.scene == scene)
        with self.engine.connect() as connection:
            return int(connection.execute(query).scalar_one())

    def pairs(self) -> int:
        """How many pairs there are, those of takes in the trash too."""
        with self.engine.connect() as connection:
            counted = connection.execute(select(func.sum(schema.chunks.c.steps)))
            return int(counted.scalar_one() or 0)

    # -- takes ---------------------------------------------------------------------------------

    def begin_take(
        self,
        session: int,
        scene: Scene,
        perception: str,
        seed: int,
        pilot: str,
        fixed: Mapping[str, AnyArray],
        now: float,
        origin: Origin | None = None,
        key: str | None = None,
    ) -> int:
        """A new take, without pairs so far; its id. `fixed` are a snapshot's, of one world.

        One that goes on from a moment of another run says so by its `origin`. Asked again with
        the same `key`, it is the take that was begun then. Raises NotFoundError.
        """
        return self.write_take(
            NewTake(
                key=key,
                session=session,
                scene_version=scene.version,
                seed=seed,
                options=dict(scene.values),
                dt_s=scene.dt_s,
                pilot=pilot,
                perception=perception,
                started_at=now,
                origin=origin,
                fixed=pack(fixed),
            )
        )

    def write_take(self, new: NewTake) -> int:
        """As `begin_take`. Raises NotFoundError where the take or its session was deleted."""
        table, gone = schema.takes, schema.deleted_takes
        values = {
            **vars(new),
            "session_id": new.session,
            "options": json.dumps(dict(new.options)),
            "pilot": checked_name(new.pilot, "pilot"),
            "origin": None if new.origin is None else json.dumps(asdict(new.origin)),
        }
        del values["session"]
        with writing(self.engine) as connection:
            number = next_number(connection, new.session)
            if new.key is not None:
                known = select(table.c.id).where(table.c.key == new.key)
                begun = connection.execute(known).scalar()
                if begun is not None:
                    return int(begun)
                deleted = select(gone.c.key).where(gone.c.key == new.key)
                if connection.execute(deleted).first() is not None:
                    raise NotFoundError(f"The take of {new.pilot!r} was deleted meanwhile.")
            return put_in(connection, table, number=number, **values)

    def append(
        self,
        take: int,
        first_step: int,
        states: AnyArray,
        actions: AnyArray,
        moving: Mapping[str, AnyArray],
    ) -> None:
        """Write the next pairs of a take, all or none of them; the same again changes nothing.

        states, actions: shape (steps, n) and (steps, m). moving: arrays of leading axis steps.
        Raises NotFoundError for a take that was deleted, ConflictError where these are not its next
        pairs.
        """
        self.write_pairs(take, first_step, len(actions), pack_pairs(states, actions, moving))

    def write_pairs(
        self, take: int, first_step: int, steps: int, packed: bytes, patient: bool = False
    ) -> None:
        """`append` of what `pack_pairs` made; see `Gathering.write`."""
        self._gathering.write(Part(take, first_step, steps, packed), patient)

    def finish_take(self, take: int, outcome: str | None, now: float) -> None:
        """Write how a take ended, None where it was broken off; nothing is appended any more."""
        self._change_take(take, outcome=outcome, ended_at=now)
        with writing(self.engine) as connection:
            join_chunks(connection, take)

    def trash_take(self, take: int, now: float) -> None:
        """Leave a take out of its session until it is restored."""
        self._change_take(take, trashed_at=now)

    def restore_take(self, take: int) -> None:
        """Bring a take back from the trash."""
        self._change_take(take, trashed_at=None)

    def note_take(self, take: int, note: str) -> None:
        """Write what a person notes of a take, in place of what was noted before."""
        self._change_take(take, note=checked_note(note))

    def empty_trash(self, session: int) -> int:
        """Delete the trashed takes of a session for good; how many there were."""
        takes = schema.takes
        gone = select(takes.c.id).where(
            takes.c.session_id == session, takes.c.trashed_at.is_not(None)
        )
        with writing(self.engine) as connection:
            # Locked: what is brought back meanwhile is not deleted.
            locked = gone.order_by(takes.c.id).with_for_update()
            ids = list(connection.execute(locked).scalars())
            for first in range(0, len(ids), TOGETHER):
                some = ids[first : first + TOGETHER]
                keys = select(takes.c.key).where(takes.c.id.in_(some), takes.c.key.is_not(None))
                connection.execute(insert(schema.deleted_takes).from_select(["key"], keys))
                for table in (schema.chunks, schema.marks, schema.verdicts):
                    connection.execute(delete(table).where(table.c.take_id.in_(some)))
                connection.execute(delete(takes).where(takes.c.id.in_(some)))
        return len(ids)

    def takes(
        self,
        session: int,
        trashed: bool | None = False,
        *,
        after: int | None = None,
        limit: int | None = None,
        newest: bool = False,
    ) -> list[TakeRecord]:
        """The takes of a session in order: kept ones, trashed ones, or with None both.

        A page of them: at most `limit`, from the one that follows the take `after`; the `newest`
        first, where that is wanted.
        """
        table = schema.takes
        query = takes_query().where(table.c.session_id == session).limit(limit)
        if newest:
            query = query.order_by(None).order_by(table.c.id.desc())
        if after is not None:
            query = query.where(table.c.id < after if newest else table.c.id > after)
        if trashed is not None:
            at = schema.takes.c.trashed_at
            query = query.where(at.is_not(None) if trashed else at.is_(None))
        with self.engine.connect() as connection:
            return [take_record(row) for row in connection.execute(query)]

    def take(self, take: int) -> TakeRecord:
        """One take. Raises NotFoundError."""
        if not 0 < take <= LARGEST_ID:
            raise no_take(take)
        with self.engine.connect() as connection:
            row = connection.execute(takes_query().where(schema.takes.c.id == take)).one_or_none()
        if row is None:
            raise no_take(take)
        return take_record(row)

    def numbers(self, takes: Sequence[int]) -> dict[int, int]:
        """Which number each of `takes` has in its session; those that are there, by id."""
        table, found = schema.takes, {}
        with self.engine.connect() as connection:
            for first in range(0, len(takes), TOGETHER):
                some = table.c.id.in_(takes[first : first + TOGETHER])
                for row in connection.execute(select(table.c.id, table.c.number).where(some)):
                    found[int(row.id)] = int(row.number)
        return found

    def find_take(self, key: str) -> TakeRecord:
        """The take that its writer knows by `key`. Raises NotFoundError."""
        query = takes_query().where(schema.takes.c.key == key)
        with self.engine.connect() as connection:
            row = connection.execute(query).one_or_none()
        if row is None:
            raise NotFoundError("The take is not saved, or it was deleted.")
        return take_record(row)

    def load_take(self, take: int) -> TakeData:
        """The content of a take. Raises NotFoundError, and StorageError where it is damaged."""
        return next(self.load_takes([take]))

    def load_takes(self, takes: Sequence[int]) -> Iterator[TakeData]:
        """The content of each of `takes`, in their order, some read at once. Raises as `load_take`.

        Where many are wanted this is faster by far.
        """
        for first in range(0, len(takes), TAKES_READ):
            some = takes[first : first + TAKES_READ]
            if not all(0 < take <= LARGEST_ID for take in some):
                raise no_take(next(take for take in some if not 0 < take <= LARGEST_ID))
            with self.engine.connect() as connection:
                found = read_takes(connection, some)
            for take in some:
                if take not in found:
                    raise no_take(take)
                yield found.pop(take)

    def _change_take(self, take: int, **values: Any) -> None:
        if not 0 < take <= LARGEST_ID:
            raise no_take(take)
        with writing(self.engine) as connection:
            query = update(schema.takes).where(schema.takes.c.id == take).values(**values)
            if connection.execute(query).rowcount == 0:
                raise no_take(take)

    # -- cleanings -----------------------------------------------------------------------------

    def save_cleaning(
        self, session: int, settings: Mapping[str, Any], marks: Marks, now: float
    ) -> int:
        """Put a cleaning in force; its id. Pairs are marked, never deleted."""
        with writing(self.engine) as connection:
            return write_cleaning(connection, session, settings, marks, now)

    def undo_cleaning(self, session: int) -> bool:
        """Take the cleaning in force back; the one before it, if any, is in force again."""
        with writing(self.engine) as connection:
            return delete_cleaning(connection, session)

    def marks(self, session: int) -> Marks:
        """The conflicts of the cleaning in force, by take; empty where there is none."""
        with self.engine.connect() as connection:
            return read_marks(connection, session)

    def judge(self, take: int, step: int, verdict: Verdict | None) -> None:
        """Write what a person says of a pair, None to withdraw it; cleanings to come heed it.

        Raises NotFoundError, and InvalidInputError for a step that the take has not.
        """
        record = self.take(take)
        if not 0 <= step < record.pairs:
            raise InvalidInputError(
                f"Take {record.number} has no moment {step}; it has {record.pairs}, from 0 on."
            )
        with writing(self.engine) as connection:
            write_verdict(connection, take, step, verdict)

    def verdicts(self, session: int) -> Verdicts:
        """What was said of the pairs of the kept takes of a session, in their order."""
        with self.engine.connect() as connection:
            return read_verdicts(connection, session)


def next_number(connection: Connection, session: int) -> int:
    """The number of a session's next take, which nobody else gets before this transaction ends.

    Raises NotFoundError.
    """
    sessions, takes = schema.sessions, schema.takes
    mine = select(sessions.c.id).where(sessions.c.id == session)
    if connection.execute(mine.with_for_update(key_share=True)).first() is None:
        raise NotFoundError(f"There is no session {session}; choose or make another.")
    last = select(func.max(takes.c.number)).where(takes.c.session_id == session)
    return int(connection.execute(last).scalar() or 0) + 1


def pack_pairs(states: AnyArray, actions: AnyArray, moving: Mapping[str, AnyArray]) -> bytes:
    """Pairs as a chunk of the store holds them; arrays as in `Store.append`."""
    arrays = {MOVING + name: array for name, array in moving.items()}
    return pack({"states": states, "actions": actions, **arrays})
