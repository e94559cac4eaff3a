"""Summaries: sessions, takes and cleanings with what is counted of them, as SQL queries."""

from __future__ import annotations

import json
from typing import Any

from sqlalchemy import Connection, Row, Select, case, func, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.records import CleaningRecord, Origin, SessionRecord, TakeRecord


def takes_query() -> Any:
    takes, chunks = schema.takes, schema.chunks
    columns = [column for column in takes.c if column.name != "fixed"]
    counted = (
        select(func.coalesce(func.sum(chunks.c.steps), 0))
        .where(chunks.c.take_id == takes.c.id)
        .scalar_subquery()
    )
    return select(*columns, counted.label("pairs")).order_by(takes.c.id)


def cleaning_query(session: int) -> Any:
    table = schema.cleanings
    query = select(table.c.id).where(table.c.session_id == session)
    return query.order_by(table.c.id.desc()).limit(1)


def take_record(row: Row[Any]) -> TakeRecord:
    return TakeRecord(
        id=row.id,
        session=row.session_id,
        number=row.number,
        scene_version=row.scene_version,
        seed=row.seed,
        options=json.loads(row.options),
        pilot=row.pilot,
        pairs=int(row.pairs),
        seconds=round(int(row.pairs) * row.dt_s, 6),
        outcome=row.outcome,
        started_at=row.started_at,
        trashed=row.trashed_at is not None,
        origin=None if row.origin is None else Origin(**json.loads(row.origin)),
        note=row.note or "",
    )


def session_records(connection: Connection, query: Select[Any]) -> list[SessionRecord]:
    """The sessions that `query` selects, with their counts, in few queries."""
    rows = connection.execute(query).all()
    takes, chunks = schema.takes, schema.chunks
    ids = [row.id for row in rows]
    kept = takes.c.trashed_at.is_(None)
    steps = (
        select(chunks.c.take_id, func.sum(chunks.c.steps).label("pairs"))
        .join(takes)
        .where(takes.c.session_id.in_(ids))
        .group_by(chunks.c.take_id)
        .subquery()
    )
    found = connection.execute(
        select(
            takes.c.session_id,
            func.sum(case((kept, 1), else_=0)),
            func.sum(case((kept, 0), else_=1)),
            func.sum(case((kept, func.coalesce(steps.c.pairs, 0)), else_=0)),
            func.sum(case((kept, func.coalesce(steps.c.pairs, 0) * takes.c.dt_s), else_=0.0)),
        )
        .select_from(takes.outerjoin(steps, steps.c.take_id == takes.c.id))
        .where(takes.c.session_id.in_(ids))
        .group_by(takes.c.session_id)
    )
    counts = {session: tuple(values) for session, *values in found}
    cleanings = _cleanings(connection, ids)
    records = []
    for row in rows:
        takes_kept, takes_trashed, pairs, seconds = counts.get(row.id, (0, 0, 0, 0.0))
        records.append(
            SessionRecord(
                id=row.id,
                name=row.name,
                scene=row.scene,
                scene_version=row.scene_version,
                demonstrator=row.demonstrator,
                created_at=row.created_at,
                made_by=row.made_by,
                takes_kept=int(takes_kept),
                takes_trashed=int(takes_trashed),
                pairs=int(pairs),
                seconds=round(float(seconds), 6),
                cleaning=cleanings.get(row.id),
            )
        )
    return records


def _cleanings(connection: Connection, sessions: list[int]) -> dict[int, CleaningRecord]:
    """The cleaning in force of each of these sessions that has one."""
    cleanings, marks = schema.cleanings, schema.marks
    latest = (
        select(func.max(cleanings.c.id))
        .where(cleanings.c.session_id.in_(sessions))
        .group_by(cleanings.c.session_id)
    )
    found = {}
    for row in connection.execute(select(cleanings).where(cleanings.c.id.in_(latest))).all():
        seen = connection.execute(
            select(marks.c.take_id, marks.c.pairs, marks.c.removed).where(
                marks.c.cleaning_id == row.id
            )
        ).all()
        kept = takes_query().where(
            schema.takes.c.session_id == row.session_id, schema.takes.c.trashed_at.is_(None)
        )
        present = {take.id: int(take.pairs) for take in connection.execute(kept) if take.pairs}
        found[row.session_id] = CleaningRecord(
            id=row.id,
            created_at=row.created_at,
            settings=json.loads(row.settings),
            pairs=sum(mark.pairs for mark in seen),
            removed=sum(mark.removed for mark in seen),
            stale=present != {mark.take_id: mark.pairs for mark in seen},
        )
    return found
