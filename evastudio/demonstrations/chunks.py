"""Chunks: the pairs of a take as rows, half a second each while it runs, joined when it ends."""

from __future__ import annotations

import numpy as np
from sqlalchemy import Connection, Row, delete, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.packing import pack, unpack
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
        old, new = (unpack(data, f"recording of take {take}") for data in (row.arrays, packed))
    except StorageError:
        return False
    return old.keys() == new.keys() and all(
        np.array_equal(old[name][begins : begins + steps], new[name], equal_nan=True)
        if new[name].dtype.kind == "f"
        else np.array_equal(old[name][begins : begins + steps], new[name])
        for name in new
    )


def read_chunks(connection: Connection, take: int) -> dict[str, AnyArray]:
    """What was recorded in a take, leading axis steps; nothing where it has no pairs.

    Raises StorageError where a chunk is damaged.
    """
    return _joined(_rows(connection, take), take)


def join_chunks(connection: Connection, take: int) -> None:
    """Put the chunks of a take that has ended together; what cannot be read stays as it is."""
    chunks = schema.chunks
    for rows in _groups(_rows(connection, take)):
        if len(rows) == 1:
            continue
        try:
            packed = pack(_joined(rows, take))
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


def _joined(rows: list[Row[tuple[int, int, bytes]]], take: int) -> dict[str, AnyArray]:
    parts = [unpack(row.arrays, f"recording of take {take}") for row in rows]
    if not parts:
        return {}
    try:
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    except (KeyError, ValueError) as error:
        raise StorageError(
            f"The recording of take {take} is damaged: its chunks do not fit together ({error})."
        ) from None
