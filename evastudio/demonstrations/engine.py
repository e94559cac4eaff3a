"""Opening a session store: everything that differs between databases is in this file."""

from __future__ import annotations

import uuid

from sqlalchemy import (
    Engine,
    ExceptionContext,
    create_engine,
    event,
    insert,
    inspect,
    select,
    update,
)
from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, DatabaseError, NoSuchModuleError, SQLAlchemyError

from evastudio.demonstrations import schema
from evastudio.errors import StorageError


def open_engine(url: str) -> Engine:
    """A connection pool on the store at `url`, its tables made or checked.

    Raises StorageError for an address that cannot be opened, a file that is no session store,
    and a store written by a newer version. Whatever the database refuses later is a StorageError
    too.
    """
    try:
        parsed = make_url(url)
        shown = parsed.render_as_string(hide_password=True)
        engine = create_engine(parsed)
    except (ArgumentError, NoSuchModuleError, ImportError) as error:
        raise StorageError(
            f"{_without_password(url)!r} is no address of a session store ({error}); give one "
            "like sqlite:///folder/studio.db."
        ) from None
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _tune_sqlite)
    try:
        _prepare(engine, shown)
    except DatabaseError as error:
        engine.dispose()
        raise StorageError(
            f"The session store {shown!r} cannot be opened: {error.orig}. If it is not a "
            "store of this studio, or damaged, move it away or choose another with --store."
        ) from None
    except SQLAlchemyError as error:
        engine.dispose()
        raise StorageError(f"The session store {shown!r} cannot be opened: {error}.") from None

    def told(context: ExceptionContext) -> Exception | None:
        if not isinstance(context.sqlalchemy_exception, DatabaseError):
            return None
        return StorageError(
            f"The session store {shown!r} cannot be used: {context.original_exception}. Try "
            "again; if it is damaged, move it away or choose another with --store."
        )

    event.listen(engine, "handle_error", told)
    return engine


def _prepare(engine: Engine, shown: str) -> None:
    with engine.begin() as connection:
        present = set(inspect(connection).get_table_names())
        if not present and engine.dialect.name == "sqlite":
            # Of several programs that open a new file at once, one makes the tables.
            connection.exec_driver_sql("BEGIN IMMEDIATE")
            present = set(inspect(connection).get_table_names())
        if schema.store.name not in present:
            if present:
                raise StorageError(
                    f"The database {shown!r} holds other tables ({', '.join(sorted(present))}); "
                    "the session store needs one of its own. Choose another with --store."
                )
            schema.metadata.create_all(connection)
            connection.execute(
                insert(schema.store).values(version=schema.VERSION, identity=str(uuid.uuid4()))
            )
            return
        version = connection.execute(select(schema.store.c.version)).scalar_one_or_none()
        if version is None or version > schema.VERSION:
            raise StorageError(
                f"The session store {shown!r} has version {version}, this program reads up to "
                f"{schema.VERSION}. Update evastudio to open it."
            )
        if version < schema.VERSION:
            # So far every version only added tables.
            schema.metadata.create_all(connection)
            connection.execute(update(schema.store).values(version=schema.VERSION))


def _tune_sqlite(connection: object, _: object) -> None:
    """WAL: readers never wait for the recorder. FULL: what is written survives a power cut."""
    cursor = connection.cursor()  # type: ignore[attr-defined]  # the driver's own connection
    for pragma in (
        "journal_mode=WAL",
        "synchronous=FULL",
        "foreign_keys=ON",
    ):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _without_password(url: str) -> str:
    scheme, found, rest = url.partition("://")
    return f"{scheme}://{rest.rpartition('@')[2]}" if found else url
