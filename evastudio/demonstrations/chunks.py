"""Chunks: the pairs of a take as rows, half a second each while it runs, joined when it ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import Connection, Row, delete, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import IN_BYTES
from evastudio.demonstrations.packing import pack, unpack, unpack_joined
from evastudio.errors import ConflictError, NotFoundError, StorageError
from evastudio.world.snapshot import AnyArray

JOINED_BYTES = 1 << 20
"""About as large joined chunks get; a reader wants few, and no database wants huge ones."""


@dataclass(frozen=True)
class Part:
    """Steps of a take as they are written."""

    take: int
    first_step: int
    steps: int
    packed: bytes


def write_chunks(connection: Connection, parts: Sequence[Part]) -> None:
    """The next steps of takes. Written again, the same changes nothing.

    However many there are, they are written by two statements. Raises NotFoundError for a take
    that was deleted, and ConflictError where a take has other steps there, or lacks some before.
    """
    present = _lengths(connection, {part.take for part in parts})
    rows: list[dict[str, object]] = []
    for part in parts:
        if part.take not in present:
            raise no_take(part.take)
        if part.first_step == present[part.take]:
            present[part.take] += part.steps
            rows.append(
                {
                    "take_id": part.take,
                    "first_step": part.first_step,
                    "steps": part.steps,
                    "arrays": part.packed,
                }
            )
        elif part.first_step > present[part.take] or not _holds(connection, part):
            raise ConflictError(
                f"Take {part.take} has {present[part.take]} steps, and these begin with step "
                f"{part.first_step}; send what follows first."
            )
        # Otherwise its writer was cut off before it was told.
    if rows:
        connection.execute(insert(schema.chunks), rows)


def _lengths(connection: Connection, takes: set[int]) -> dict[int, int]:
    """How many steps each of `takes` has so far, without those that were deleted.

    None of them is deleted while the transaction lasts.
    """
    table, chunks = schema.takes, schema.chunks
    last = select(chunks.c.first_step + chunks.c.steps).where(chunks.c.take_id == table.c.id)
    length = last.order_by(chunks.c.first_step.desc()).limit(1).scalar_subquery()
    query = select(table.c.id, length).where(table.c.id.in_(takes)).order_by(table.c.id)
    rows = connection.execute(query.with_for_update(read=True, key_share=True, of=table))
    return {take: present or 0 for take, present in rows}


def no_take(take: int) -> NotFoundError:
    """The error for a take that is not there."""
    return NotFoundError(f"There is no take {take}, or nothing was recorded in it.")


def _holds(connection: Connection, part: Part) -> bool:
    """Whether the take has just these steps already, maybe joined with others."""
    chunks = schema.chunks
    take, first_step, steps, packed = part.take, part.first_step, part.steps, part.packed
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
