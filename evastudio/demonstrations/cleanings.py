"""Cleanings in the store: which pairs of a session are marked as conflicts, and were before."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from sqlalchemy import Connection, delete, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.records import Marks
from evastudio.demonstrations.summaries import cleaning_query
from evastudio.demonstrations.verdicts import write_verdict


def write_cleaning(
    connection: Connection, session: int, settings: Mapping[str, Any], marks: Marks, now: float
) -> int:
    """A new cleaning, in force from now on; its id. Takes that were deleted meanwhile are left out.

    For a transaction that writes.
    """
    cleanings, takes = schema.cleanings, schema.takes
    made = connection.execute(
        insert(cleanings)
        .values(session_id=session, created_at=now, settings=json.dumps(dict(settings)))
        .returning(cleanings.c.id)
    ).scalar_one()
    kept = select(takes.c.id).where(takes.c.session_id == session).order_by(takes.c.id)
    present = set(connection.execute(kept.with_for_update(read=True, key_share=True)).scalars())
    rows = [
        {
            "cleaning_id": made,
            "take_id": take,
            "pairs": len(mask),
            "removed": int(mask.sum()),
            "mask": np.packbits(mask).tobytes(),
        }
        for take, mask in marks.items()
        if take in present
    ]
    if rows:
        connection.execute(insert(schema.marks), rows)
    return int(made)


def delete_cleaning(connection: Connection, session: int) -> bool:
    """Delete the cleaning in force, so that the one before it is; False where there is none.

    Where it was of a single pair, what was said of that is withdrawn too.
    """
    locked = cleaning_query(session).with_for_update()
    cleaning = connection.execute(locked).scalar_one_or_none()
    if cleaning is None:
        return False
    connection.execute(delete(schema.marks).where(schema.marks.c.cleaning_id == cleaning))
    made = delete(schema.cleanings).where(schema.cleanings.c.id == cleaning)
    told = connection.execute(made.returning(schema.cleanings.c.settings)).scalar_one()
    moment = json.loads(told).get("moment")
    if moment is not None:
        take, step = moment
        write_verdict(connection, take, step, None)
    return True


def read_marks(connection: Connection, session: int) -> Marks:
    """The conflicts of the cleaning in force, by take; empty where there is none."""
    cleaning = connection.execute(cleaning_query(session)).scalar_one_or_none()
    rows = connection.execute(select(schema.marks).where(schema.marks.c.cleaning_id == cleaning))
    return {
        row.take_id: np.unpackbits(np.frombuffer(row.mask, np.uint8), count=row.pairs).astype(bool)
        for row in rows
    }
