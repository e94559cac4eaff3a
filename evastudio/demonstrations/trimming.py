"""Keeping the end of a take: the rest is another take's, and goes to the trash with it."""

from __future__ import annotations

import json
from dataclasses import asdict

from sqlalchemy import insert, select, update

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.packing import MOVING, pack
from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.demonstrations.rows import put_in
from evastudio.demonstrations.store import Store, next_number
from evastudio.errors import InvalidInputError


def keep_last(store: Store, take: int, seconds: float, now: float) -> int:
    """A new take of the last `seconds` of `take`, which goes to the trash; the new one's id.

    The new one begins at a moment of the old, as its origin says. All or nothing is written.
    Raises InvalidInputError where that would keep nothing or everything, NotFoundError.
    """
    record, data = store.take(take), store.load_take(take)
    dt_s = record.seconds / record.pairs
    kept = round(seconds / dt_s) if 0.0 < seconds < record.seconds else 0
    if not 0 < kept < record.pairs:
        raise InvalidInputError(
            f"Take {record.number} lasts {record.seconds:g} s, so its last {seconds:g} s cannot be "
            f"kept apart; choose from {dt_s:.2g} to {record.seconds - dt_s:.3g} s."
        )
    first = record.pairs - kept
    arrays = {MOVING + name: array[first:] for name, array in data.snapshots.moving.items()}
    packed = pack({"states": data.states[first:], "actions": data.actions[first:], **arrays})
    takes = schema.takes
    with writing(store.engine) as connection:
        number = next_number(connection, record.session)
        old = connection.execute(select(takes).where(takes.c.id == take)).one()._asdict()
        origin = Origin(first, take=take, seed=None if record.seed == RECORDED else record.seed)
        changed = {
            "number": number,
            "seed": RECORDED,
            "key": None,
            "started_at": record.started_at + first * dt_s,
            "trashed_at": None,
            "origin": json.dumps(asdict(origin)),
        }
        del old["id"]
        made = put_in(connection, takes, **{**old, **changed})
        connection.execute(
            insert(schema.chunks).values(take_id=made, first_step=0, steps=kept, arrays=packed)
        )
        connection.execute(update(takes).where(takes.c.id == take).values(trashed_at=now))
    return made
