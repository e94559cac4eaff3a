"""The session store: does it open, is every take whole, does anything wait to be written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

from sqlalchemy import delete, exists, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.packing import unpack
from evastudio.demonstrations.spill_file import ASIDE
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.unsaved import take_in, unsaved
from evastudio.errors import StorageError
from evastudio.live.doctor.finding import Finding
from evastudio.workspace import Workspace

OLD_S = 3600.0
"""A take that has no end, and began so long ago, is not being recorded any more."""
TRASHED = "It goes to the trash, from where it can be brought back."


def look_at_store(workspace: Workspace, now: float) -> Iterator[Finding]:
    if workspace.store is None and not (workspace.root / "studio.db").exists():
        return  # nothing was recorded yet, and looking makes no store
    try:
        store = Store(workspace.store_url)
    except StorageError as error:
        yield Finding("store", f"{error} A backup can be put back with `evastudio restore`.")
        return
    with closing(store):
        try:
            yield from _whole(store)
            yield from _unsaved(store, workspace)
            yield from _takes(store, now)
            yield from _marks(store)
        except StorageError as error:
            yield Finding("store", str(error))


def _whole(store: Store) -> Iterator[Finding]:
    """What the database says of itself. PostgreSQL says nothing: there every take is read."""
    if store.engine.dialect.name != "sqlite":
        return
    with store.engine.connect() as connection:
        told = connection.exec_driver_sql("PRAGMA integrity_check(3)").scalars().all()
        astray = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    if list(told) != ["ok"]:
        yield Finding(
            "store",
            f"The database is damaged ({'; '.join(map(str, told))}). Put a backup back with "
            "`evastudio restore`.",
        )
    if astray:
        tables = ", ".join(sorted({str(row[0]) for row in astray}))
        yield Finding("store", f"Rows of {tables} belong to nothing that is there.")


def _unsaved(store: Store, workspace: Workspace) -> Iterator[Finding]:
    for waiting in unsaved(workspace.unsaved, store.identity):
        if waiting.problem is not None:
            aside = waiting.path.with_name(waiting.path.name + ASIDE)
            yield Finding(
                str(waiting.path),
                waiting.problem,
                "It gets another name, under which nobody looks for it.",
                partial(waiting.path.rename, aside),
            )
        elif waiting.pairs:
            yield Finding(
                str(waiting.path),
                f"{waiting.pairs} pairs of {waiting.takes} takes wait to be saved, some of which "
                "may be in the store already.",
                "They are saved, each once.",
                partial(take_in, store, workspace.unsaved),
            )
    for path in _kept(workspace):
        yield Finding(
            str(path),
            "Takes are kept in this file that found no place: their session or their beginning is "
            "not in the store. Put back the store they belong to, or delete the file.",
            wrong=False,
        )


def _kept(workspace: Workspace) -> list[Path]:
    return sorted(path for folder in workspace.unsaved for path in folder.glob("*" + ASIDE))


def _takes(store: Store, now: float) -> Iterator[Finding]:
    takes = schema.takes
    with store.engine.connect() as connection:
        begun = select(takes.c.id).where(
            takes.c.ended_at.is_(None), takes.c.started_at < now - OLD_S
        )
        open_still = set(connection.execute(begun).scalars())
    for session in store.sessions():
        for take in store.takes(session.id, trashed=None):
            about = f"take {take.number} of session {session.id}, {session.name!r}"
            if take.trashed:
                continue
            trash = partial(store.trash_take, take.id, now)
            if not take.pairs:
                yield Finding(about, "Nothing was recorded in it.", TRASHED, trash)
                continue
            damage = _damage(store, take.id)
            if damage is not None:
                yield Finding(about, f"{damage} It cannot be learned from.", TRASHED, trash)
            elif take.id in open_still:
                yield Finding(
                    about,
                    "It was broken off: the studio was ended while it was recorded. What there is "
                    "of it is whole.",
                    "It is closed as it is.",
                    partial(store.finish_take, take.id, None, now),
                    wrong=False,
                )


def _damage(store: Store, take: int) -> str | None:
    """What is wrong with what was recorded in a take."""
    chunks, takes = schema.chunks, schema.takes
    query = select(chunks.c.first_step, chunks.c.steps, chunks.c.arrays)
    with store.engine.connect() as connection:
        rows = connection.execute(query.where(chunks.c.take_id == take).order_by("first_step"))
        step = 0
        for row in rows:
            if row.first_step != step:
                return f"Its steps from {step} to {row.first_step - 1} are missing."
            try:
                arrays = unpack(row.arrays, f"recording from step {step} on")
            except StorageError as error:
                return str(error)
            if {len(array) for array in arrays.values()} != {row.steps} or "states" not in arrays:
                return f"Its recording from step {step} on does not have {row.steps} steps."
            step += row.steps
        world = connection.execute(select(takes.c.fixed).where(takes.c.id == take)).scalar_one()
    try:
        unpack(world, "world")
    except StorageError as error:
        return str(error)
    return None


def _marks(store: Store) -> Iterator[Finding]:
    marks, takes, cleanings = schema.marks, schema.takes, schema.cleanings
    nowhere = ~exists().where(takes.c.id == marks.c.take_id) | ~exists().where(
        cleanings.c.id == marks.c.cleaning_id
    )
    with store.engine.connect() as connection:
        count = len(connection.execute(select(marks.c.take_id).where(nowhere)).all())
    if count:

        def forget() -> None:
            with writing(store.engine) as connection:
                connection.execute(delete(marks).where(nowhere))

        yield Finding(
            "store",
            f"Cleaning marked pairs of {count} takes that are gone.",
            "The marks, which nobody can see, are deleted.",
            forget,
        )
