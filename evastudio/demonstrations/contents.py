"""What takes hold: their worlds and chunks, read from the store as arrays over all their steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sqlalchemy import Connection, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.chunks import read_chunks
from evastudio.demonstrations.engine import IN_BYTES
from evastudio.demonstrations.packing import MOVING, unpack
from evastudio.demonstrations.records import TakeData
from evastudio.world.snapshot import AnyArray, moments_of


def read_takes(connection: Connection, takes: Sequence[int]) -> dict[int, TakeData]:
    """The content of `takes`, without those that are not there or have no pairs.

    Raises StorageError where one is damaged.
    """
    table = schema.takes
    query = select(table.c.id, table.c.fixed).where(table.c.id.in_(takes))
    fixed = {row.id: row.fixed for row in connection.execute(query.execution_options(**IN_BYTES))}
    return {
        take: _content(unpack(fixed[take], f"world of take {take}"), recorded)
        for take, recorded in read_chunks(connection, takes).items()
        if take in fixed
    }


def _content(world: Mapping[str, AnyArray], recorded: Mapping[str, AnyArray]) -> TakeData:
    moving = {
        name.removeprefix(MOVING): array
        for name, array in recorded.items()
        if name.startswith(MOVING)
    }
    return TakeData(moments_of(world, moving), recorded["states"], recorded["actions"])
