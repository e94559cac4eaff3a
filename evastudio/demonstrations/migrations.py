"""Bringing a store forward: its tables are made, or what newer versions added to them is added."""

from __future__ import annotations

import uuid
from collections.abc import Callable

from sqlalchemy import Connection, Engine, Table, insert, inspect, select, text, update
from sqlalchemy.schema import CreateColumn

from evastudio.demonstrations import schema
from evastudio.errors import StorageError

Lock = Callable[[Connection, str], None]
"""Begins the transaction in which nobody else changes the tables of the store so named."""

STEPS: dict[int, Callable[[Connection], None]] = {}
"""What else a version asks for once its tables are there: by version, called in order."""


def migrate(engine: Engine, shown: str, lock: Lock) -> None:
    """Make the tables of a new store, or add to an old one what it lacks, all or nothing.

    Raises StorageError where there are tables of others, or of a newer version. `shown` names
    the store in messages.
    """
    with engine.connect() as connection:
        if _version(connection, shown) == schema.VERSION:
            return
    with engine.begin() as connection:
        lock(connection, shown)
        version = _version(connection, shown)  # others may have been first
        if version == schema.VERSION:
            return
        schema.metadata.create_all(connection, checkfirst=version is not None)
        if version is None:
            connection.execute(
                insert(schema.store).values(version=schema.VERSION, identity=str(uuid.uuid4()))
            )
            return
        for table in schema.metadata.sorted_tables:
            _complete(connection, table)
        for step in range(version + 1, schema.VERSION + 1):
            if step in STEPS:
                STEPS[step](connection)
        connection.execute(update(schema.store).values(version=schema.VERSION))


def _version(connection: Connection, shown: str) -> int | None:
    """The version of the store, None where there is nothing yet."""
    present = set(inspect(connection).get_table_names())
    if schema.store.name not in present:
        if present:
            raise StorageError(
                f"The database {shown!r} holds other tables ({', '.join(sorted(present))}); "
                "the session store needs one of its own. Choose another with --store."
            )
        return None
    version = connection.execute(select(schema.store.c.version)).scalar_one_or_none()
    if version is None or version > schema.VERSION:
        raise StorageError(
            f"The session store {shown!r} has version {version}, this program reads up to "
            f"{schema.VERSION}. Update evastudio to open it."
        )
    return int(version)


def _complete(connection: Connection, table: Table) -> None:
    """Add the columns and indexes that a table of an older version lacks."""
    seen = inspect(connection)
    columns = {column["name"] for column in seen.get_columns(table.name)}
    for column in table.columns:
        if column.name not in columns:
            added = CreateColumn(column).compile(dialect=connection.dialect)
            connection.execute(text(f"ALTER TABLE {table.name} ADD COLUMN {added}"))
    indexes = {index["name"] for index in seen.get_indexes(table.name)}
    for index in table.indexes:
        if index.name not in indexes:
            index.create(connection)
