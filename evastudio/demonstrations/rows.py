"""Rows of the store's tables: one put in, one by its id, a page of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sqlalchemy import Connection, Engine, Row, Select, Table, insert, select

LARGEST_ID = 2**31 - 1
"""What an Integer column holds in every database."""


def put_in(connection: Connection, table: Table, **values: Any) -> int:
    """A new row; its id."""
    result = connection.execute(insert(table).values(**values))
    assert result.inserted_primary_key is not None
    return int(result.inserted_primary_key[0])


def row_at(
    engine: Engine, table: Table, number: int, columns: Iterable[Any] | None = None
) -> Row[Any] | None:
    """The row of that id, or some `columns` of it; None where there is none."""
    if not 0 < number <= LARGEST_ID:
        return None
    query = select(*(table.c if columns is None else columns)).where(table.c.id == number)
    with engine.connect() as connection:
        return connection.execute(query).one_or_none()


def newest_first(
    table: Table,
    scene: str | None = None,
    after: int | None = None,
    limit: int | None = None,
    columns: Iterable[Any] | None = None,
) -> Select[Any]:
    """All rows, or some `columns` of them; those of one scene where `scene` is given.

    A page of them: at most `limit`, from the one that follows the row of the id `after`.
    """
    query = select(*(table.c if columns is None else columns)).order_by(table.c.id.desc())
    if scene is not None:
        query = query.where(table.c.scene == scene)
    if after is not None:
        query = query.where(table.c.id < after)
    return query.limit(limit)
