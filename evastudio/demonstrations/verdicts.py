"""Verdicts: what a person says of single pairs, and what cleanings make of it."""

from __future__ import annotations

import numpy as np
from sqlalchemy import Connection, delete, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.records import Marks, Verdict, Verdicts


def write_verdict(connection: Connection, take: int, step: int, verdict: Verdict | None) -> None:
    """The verdict on a pair in place of an earlier one; None only takes that away.

    For a transaction that writes.
    """
    table = schema.verdicts
    connection.execute(delete(table).where(table.c.take_id == take, table.c.step == step))
    if verdict is not None:
        connection.execute(insert(table).values(take_id=take, step=step, verdict=verdict.value))


def read_verdicts(connection: Connection, session: int) -> Verdicts:
    """Those on pairs of the kept takes of a session, in the order of takes and steps."""
    table, takes = schema.verdicts, schema.takes
    query = (
        select(table)
        .join(takes)
        .where(takes.c.session_id == session, takes.c.trashed_at.is_(None))
        .order_by(table.c.take_id, table.c.step)
    )
    rows = connection.execute(query)
    return {(row.take_id, row.step): Verdict(row.verdict) for row in rows}


def judged(marks: Marks, verdicts: Verdicts) -> Marks:
    """`marks` as the `verdicts` have them: what is to be kept unmarked, what is to go marked."""
    masks = {take: np.array(mask) for take, mask in marks.items()}
    for (take, step), verdict in verdicts.items():
        if take in masks and step < len(masks[take]):
            masks[take][step] = verdict is Verdict.DELETE
    return masks
