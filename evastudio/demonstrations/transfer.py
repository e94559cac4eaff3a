"""Copying a whole store, as it is at one moment, into an empty one of either database."""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import Connection, Table, func, insert, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import count_on, reading, writing
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError

TOGETHER = 64
"""Rows read and written at once; some hold a megabyte."""

LEFT_OUT = (schema.store, schema.tokens, schema.answers)
"""Tokens open the studio that gave them out, not its copies; answers are for who asked just now."""

Progress = Callable[[float, str], None]


def copy_store(source: Store, target: Store, progress: Progress) -> dict[str, int]:
    """Copy what `source` holds into `target`, all or nothing; how many rows of each table.

    Others go on writing into `source`; what they write from now on is not copied. `target` is
    afterwards the same store under the same identity. Raises ConflictError where it is not empty.
    """
    copied: dict[str, int] = {}
    tables = _tables()
    with reading(source.engine) as old, writing(target.engine) as new:
        _check_empty(new)
        rows = {
            table.name: old.execute(select(func.count()).select_from(table)).scalar_one()
            for table in tables
        }
        total, done = sum(rows.values()), 0
        for table in tables:
            found = old.execute(select(table).execution_options(yield_per=TOGETHER))
            for some in found.mappings().partitions():
                new.execute(insert(table), [dict(row) for row in some])
                done += len(some)
                progress(done / total, table.name)
            count_on(new, table)
            copied[table.name] = rows[table.name]
        identity = old.execute(select(schema.store.c.identity)).scalar_one()
        new.execute(update(schema.store).values(identity=identity))
    return copied


def is_empty(store: Store) -> bool:
    """Whether nothing was ever written into a store."""
    with store.engine.connect() as connection:
        return _holds(connection) is None


def _check_empty(connection: Connection) -> None:
    holds = _holds(connection)
    if holds is not None:
        raise ConflictError(
            f"The session store is not empty, it holds {holds}; nothing was written. Choose "
            "another workspace, or an empty database with --store."
        )


def _holds(connection: Connection) -> str | None:
    for table in _tables():
        if connection.execute(select(table).limit(1)).first():
            return table.name
    return None


def _tables() -> list[Table]:
    return [table for table in schema.metadata.sorted_tables if table not in LEFT_OUT]
