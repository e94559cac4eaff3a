"""Opening a session store: everything that differs between databases is in this file."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any, cast

from sqlalchemy import (
    URL,
    Connection,
    Engine,
    ExceptionContext,
    PoolProxiedConnection,
    QueuePool,
    Table,
    create_engine,
    event,
    func,
    select,
    text,
)
from sqlalchemy.engine import ExecutionContext, make_url
from sqlalchemy.exc import ArgumentError, DatabaseError, DataError, SQLAlchemyError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from evastudio.demonstrations.migrations import migrate
from evastudio.errors import InvalidInputError, StorageError, StudioError

SQLITE, POSTGRESQL = "sqlite", "postgresql"
DRIVERS = {SQLITE: "sqlite+pysqlite", POSTGRESQL: "postgresql+psycopg"}

CONNECTIONS = 8
"""Kept open by one program."""
MORE_CONNECTIONS = 24
"""Opened besides while there is much to do. A PostgreSQL server takes a hundred unless told."""
POOL_WAIT_S = 10.0
LOCK_WAIT_S = 5.0
"""So long a write waits for another; then it is a StorageError, and a recorder tries again."""
STATEMENT_S = 60.0
"""So long one statement may take on a server."""
CACHE_KB = 512
"""Of a database file, for each connection; the system keeps the file in memory for all of them."""
LOST = {
    "connect_timeout": 5,
    "keepalives_idle": 10,
    "keepalives_interval": 3,
    "keepalives_count": 3,
    "tcp_user_timeout": 10_000,
}
"""libpq's settings by which a server that is gone is known to be, in s, and the last in ms."""
STORE_LOCK = 0x65766173
"""Of those who make or change tables on a PostgreSQL server, one at a time holds this."""


IN_BYTES = {"in_bytes": True}
"""Execution options of a query for much that is packed: it need not travel as text."""


def open_engine(url: str) -> Engine:
    """A connection pool on the store at `url`, its tables made or brought up to date.

    Raises StorageError for an address that cannot be opened, a database that holds something
    else, and a store written by a newer version. Whatever the database refuses later is a
    StorageError too. None of them tells the password.
    """
    parsed = parse_url(url)
    shown = _shown(parsed)
    engine = _engine(parsed, shown)
    try:
        migrate(engine, shown, _changing)
    except DatabaseError as error:
        engine.dispose()
        if _is_server(engine):
            hint = "Check that the server runs and that address, user and password are right"
        else:
            hint = "If it is not a store of this studio, or damaged, move it away"
        raise StorageError(
            f"The session store {shown!r} cannot be opened: {_told(error)}. {hint}, or choose "
            "another with --store."
        ) from None
    except SQLAlchemyError as error:
        engine.dispose()
        raise StorageError(f"The session store {shown!r} cannot be opened: {error}.") from None
    except StudioError:
        engine.dispose()
        raise

    def told(context: ExceptionContext) -> Exception | None:
        if context.is_pre_ping:  # another connection takes the place of one that was cut
            return None
        refused = (DataError, OverflowError, UnicodeEncodeError)
        if isinstance(context.sqlalchemy_exception or context.original_exception, refused):
            return InvalidInputError(
                f"The session store cannot keep that: {context.original_exception}. Numbers have "
                "at most 64 bits, and texts the length and the characters of a text."
            )
        if not isinstance(context.sqlalchemy_exception, DatabaseError):
            return None
        return StorageError(
            f"The session store {shown!r} cannot be used: {_told(context.sqlalchemy_exception)}. "
            "Try again; if it is damaged, move it away or choose another with --store."
        )

    event.listen(engine, "handle_error", told)
    event.listen(engine, "before_cursor_execute", _check_texts)
    return engine


@contextlib.contextmanager
def writing(engine: Engine) -> Iterator[Connection]:
    """A transaction whose reads still hold when it writes, on rows it locks `for update`.

    SQLite locks no rows: there it is the only one that writes from its beginning on. Threads of
    this program take turns before they ask SQLite, which lets those who ask together starve.
    """
    if _is_server(engine):
        with engine.begin() as connection:
            yield connection
        return
    turn = cast("_Pool", engine.pool).turn
    if not turn.acquire(timeout=LOCK_WAIT_S):
        raise StorageError(f"The session store was being written for {LOCK_WAIT_S:g} s. Try again.")
    try:
        with engine.begin() as connection:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
            yield connection
    finally:
        turn.release()


@contextlib.contextmanager
def reading(engine: Engine) -> Iterator[Connection]:
    """A transaction that sees the store as it is at one moment, whatever others write meanwhile."""
    with engine.connect() as connection:
        if _is_server(engine):
            connection.execution_options(isolation_level="REPEATABLE READ")
            connection.execute(text("SET TRANSACTION READ ONLY"))
        else:
            connection.exec_driver_sql("BEGIN")
        yield connection


def count_on(connection: Connection, table: Table) -> None:
    """Let new rows of `table` go on from the ids that were written into it."""
    column = table.autoincrement_column
    if connection.dialect.name == POSTGRESQL and column is not None:
        last = select(func.max(column)).scalar_subquery()
        counter = func.pg_get_serial_sequence(table.name, column.name)
        connection.execute(select(func.setval(counter, func.coalesce(last, 1), last.is_not(None))))


def parse_url(url: str) -> URL:
    """`url` with the driver that is meant. Raises StorageError for what is no store's address."""
    like = "give one like sqlite:///folder/studio.db or postgresql+psycopg://user@host/database"
    try:
        parsed = make_url(url)
    except (ArgumentError, ValueError):
        raise StorageError(
            f"{_without_password(url)!r} is no address of a session store; {like}."
        ) from None
    kind = parsed.get_backend_name()
    if kind not in DRIVERS or parsed.drivername not in (kind, DRIVERS[kind]):
        raise StorageError(
            f"{_without_password(url)!r} is no address of a session store, which is kept by "
            f"SQLite or PostgreSQL; {like}."
        )
    if "@" in f"{parsed.host}{parsed.database if kind == POSTGRESQL else ''}":
        raise StorageError(
            "The address of the session store has more than one '@'; write one that belongs to "
            "the password as %40, and '/' as %2F."
        )
    secret = parsed.query.get("password")
    if isinstance(secret, str):
        parsed = parsed.difference_update_query(["password"]).set(password=secret)
    return parsed.set(drivername=DRIVERS[kind])


def _engine(url: URL, shown: str) -> Engine:
    settings: dict[str, Any] = {}
    if url.get_backend_name() == POSTGRESQL:
        limits = {
            "lock_timeout": LOCK_WAIT_S,
            "statement_timeout": STATEMENT_S,
            "idle_in_transaction_session_timeout": STATEMENT_S,
        }
        options = " ".join(f"-c {name}={seconds * 1000:.0f}" for name, seconds in limits.items())
        given = {**LOST, "options": options, "client_encoding": "utf8", **url.query}
        settings = {"connect_args": given, "pool_pre_ping": True}
    elif "timeout" not in url.query:
        settings = {"connect_args": {"timeout": LOCK_WAIT_S}}
    try:
        engine = create_engine(
            url,
            poolclass=_Pool,
            pool_size=CONNECTIONS,
            max_overflow=MORE_CONNECTIONS,
            pool_timeout=POOL_WAIT_S,
            **settings,
        )
    except ImportError:
        raise StorageError(
            f"The session store {shown!r} needs the package psycopg; install it with "
            "pip install 'evastudio[postgres]'."
        ) from None
    if _is_server(engine):
        event.listen(engine, "before_cursor_execute", _ask_in_bytes)
    else:
        event.listen(engine, "connect", _tune_sqlite)
    return engine


class _Pool(QueuePool):
    """A pool that says in a sentence when it is empty for too long."""

    def __init__(self, *given: Any, **settings: Any) -> None:
        super().__init__(*given, **settings)
        self.turn = threading.Lock()
        """Held by the thread that writes, where the database lets only one."""

    def connect(self) -> PoolProxiedConnection:
        try:
            return super().connect()
        except PoolTimeoutError:
            raise StorageError(
                f"The session store was busy for {POOL_WAIT_S:g} s: all "
                f"{CONNECTIONS + MORE_CONNECTIONS} connections to it are in use. Try again."
            ) from None


def _changing(connection: Connection, shown: str) -> None:
    """Keep other programs from changing the tables until this transaction ends."""
    if connection.dialect.name == SQLITE:
        connection.exec_driver_sql("BEGIN IMMEDIATE")
        return
    for limit in ("lock_timeout", "statement_timeout"):
        connection.execute(text(f"SET LOCAL {limit} = 0"))
    connection.execute(text(f"SELECT pg_advisory_xact_lock({STORE_LOCK})"))
    encoding = connection.execute(text("SHOW server_encoding")).scalar_one()
    if encoding != "UTF8":
        raise StorageError(
            f"The session store {shown!r} keeps text as {encoding}, which does not hold every "
            "name; make its database with ENCODING 'UTF8'."
        )


def _check_texts(
    _: Connection, __: object, ___: str, parameters: Any, ____: object, many: bool
) -> None:
    """Refuse the character that SQLite would keep and PostgreSQL does not."""
    for row in parameters if many else (parameters,):
        for value in row.values() if isinstance(row, dict) else row:
            if isinstance(value, str) and "\x00" in value:
                raise InvalidInputError(
                    f"The text {value[:40]!r} holds the character NUL; leave it out."
                )


def _ask_in_bytes(
    _: Connection, cursor: Any, __: str, ___: object, context: ExecutionContext, ____: bool
) -> None:
    """psycopg asks for text otherwise, in which a byte has two letters."""
    if context.execution_options.get("in_bytes"):
        from psycopg.pq import Format

        cursor.format = Format.BINARY


def _tune_sqlite(connection: object, _: object) -> None:
    """WAL: readers never wait for the recorder. FULL: what is written survives a power cut."""
    cursor = connection.cursor()  # type: ignore[attr-defined]  # the driver's own connection
    for pragma in (
        "journal_mode=WAL",
        "synchronous=FULL",
        "foreign_keys=ON",
        f"cache_size=-{CACHE_KB}",
    ):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _is_server(engine: Engine) -> bool:
    return engine.dialect.name == POSTGRESQL


def _told(error: DatabaseError) -> str:
    """What the database said, on one line."""
    return " ".join(str(error.orig).split()).rstrip(".")


def _shown(url: URL) -> str:
    """An address without what may be secret."""
    if url.get_backend_name() == POSTGRESQL:
        return url.set(password=None, query={}, drivername=POSTGRESQL).render_as_string()
    return url.render_as_string(hide_password=True)


def _without_password(url: str) -> str:
    scheme, found, rest = url.partition("://")
    return f"{scheme}://{rest.rpartition('@')[2].partition('?')[0]}" if found else url
