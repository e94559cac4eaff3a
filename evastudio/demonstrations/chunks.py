"""Chunks: the pairs of a take as rows, half a second each while it runs, joined when it ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sqlalchemy import Connection, Row, delete, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import IN_BYTES
from evastudio.demonstrations.packing import pack, unpack, unpack_joined
from evastudio.errors import ConflictError, StorageError
from evastudio.world.snapshot import AnyArray

JOINED_BYTES = 1 << 20
"""About as large joined chunks get; a reader wants few, and no database wants huge ones."""


def write_chunk(
    connection: Connection, take: int, first_step: int, steps: int, packed: bytes
) -> None:
    """The next steps of a take, from `first_step` on. Written again, the same changes nothing.

    Raises ConflictError where the take has other steps there, or lacks some before them.
    """
    chunks = schema.chunks
    last = select(chunks.c.first_step, chunks.c.steps).where(chunks.c.take_id == take)
    row = connection.execute(last.order_by(chunks.c.first_step.desc()).limit(1)).first()
    present = 0 if row is None else row.first_step + row.steps
    if first_step < present and _holds(connection, take, first_step, steps, packed):
        return  # its writer was cut off before it was told
    if first_step != present:
        raise ConflictError(
            f"Take {take} has {present} steps, and these begin with step {first_step}; send what "
            "follows first."
        )
    connection.execute(
        insert(chunks).values(take_id=take, first_step=first_step, steps=steps, arrays=packed)
    )


def _holds(connection: Connection, take: int, first_step: int, steps: int, packed: bytes) -> bool:
    """Whether the take has just these steps already, maybe joined with others."""
    chunks = schema.chunks
    around = select(chunks.c.first_step, chunks.c.steps, chunks.c.arrays).where(
        chunks.c.take_id == take, chunks.c.first_step <= first_step
    )
    row = connection.execute(around.order_by(chunks.c.first_step.desc()).limit(1)).first()
    if row is None:
        return False
    if row.arrays == packed:
        return True
    begins = first_step - row.first_step
    try:
        old, new = (unpack(data, _recording(take)) for data in (row.arrays, packed))
    except StorageError:
        return False
    return old.keys() == new.keys() and all(
        np.array_equal(old[name][begins : begins + steps], new[name], equal_nan=True)
        if new[name].dtype.kind == "f"
        else np.array_equal(old[name][begins : begins + steps], new[name])
        for name in new
    )


def read_chunks(connection: Connection, takes: Sequence[int]) -> dict[int, dict[str, AnyArray]]:
    """What was recorded in each of `takes`, leading axis steps; without those that have no pairs.

    Raises StorageError where a chunk is damaged.
    """
    chunks = schema.chunks
    query = select(chunks.c.take_id, chunks.c.arrays).where(chunks.c.take_id.in_(takes))
    query = query.order_by(chunks.c.take_id, chunks.c.first_step).execution_options(**IN_BYTES)
    parts: dict[int, list[bytes]] = {}
    for take, arrays in connection.execute(query):
        parts.setdefault(take, []).append(arrays)
    return {take: unpack_joined(some, _recording(take)) for take, some in parts.items()}


def join_chunks(connection: Connection, take: int) -> None:
    """Put the chunks of a take that has ended together; what cannot be read stays as it is."""
    chunks = schema.chunks
    for rows in _groups(_rows(connection, take)):
        if len(rows) == 1:
            continue
        try:
            packed = pack(unpack_joined([row.arrays for row in rows], _recording(take)))
        except StorageError:
            continue
        first, last = rows[0].first_step, rows[-1].first_step
        connection.execute(
            delete(chunks).where(chunks.c.take_id == take, chunks.c.first_step.between(first, last))
        )
        steps = sum(row.steps for row in rows)
        connection.execute(
            insert(chunks).values(take_id=take, first_step=first, steps=steps, arrays=packed)
        )


def _rows(connection: Connection, take: int) -> list[Row[tuple[int, int, bytes]]]:
    chunks = schema.chunks
    query = select(chunks.c.first_step, chunks.c.steps, chunks.c.arrays)
    query = query.where(chunks.c.take_id == take).order_by(chunks.c.first_step)
    return list(connection.execute(query))


def _groups(
    rows: list[Row[tuple[int, int, bytes]]],
) -> list[list[Row[tuple[int, int, bytes]]]]:
    """`rows` in order, in groups of about JOINED_BYTES."""
    groups: list[list[Row[tuple[int, int, bytes]]]] = []
    size = JOINED_BYTES
    for row in rows:
        size += len(row.arrays)
        if size > JOINED_BYTES:
            groups.append([])
            size = len(row.arrays)
        groups[-1].append(row)
    return groups


def _recording(take: int) -> str:
    return f"recording of take {take}"
