"""Evaluations in the session store: what was asked, under which versions, and every world's end."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Row, insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.packing import pack, unpack
from evastudio.demonstrations.store import LARGEST_ID, Store
from evastudio.errors import NotFoundError
from evastudio.evaluation.results import Comparison
from evastudio.evaluation.versions import versions


@dataclass(frozen=True)
class EvaluationRecord:
    """One stored evaluation."""

    id: int
    scene: str
    created_at: float
    """Seconds since the epoch."""
    asked: Mapping[str, Any]
    """What it takes to make it again: policies, with the fingerprints of their files, and so on."""
    versions: Mapping[str, str]
    """Of Python and the packages that figures depend on."""
    result: Mapping[str, Any]
    """`Comparison.to_json()`."""


def save_evaluation(
    store: Store, comparison: Comparison, asked: Mapping[str, Any], now: float
) -> int:
    """Keep `comparison`; its id. `now` in seconds since the epoch."""
    with store.engine.begin() as connection:
        made = connection.execute(
            insert(schema.evaluations).values(
                scene=comparison.scene["name"],
                created_at=now,
                asked=json.dumps(dict(asked)),
                versions=json.dumps(versions()),
                result=json.dumps(comparison.to_json(), allow_nan=False),
                arrays=pack(comparison.to_arrays()),
            )
        )
    return int((made.inserted_primary_key or (0,))[0])


def evaluations(
    store: Store,
    scene: str | None = None,
    *,
    after: int | None = None,
    limit: int | None = None,
) -> list[EvaluationRecord]:
    """All evaluations, newest first; those of one scene where `scene` is given.

    A page of them: at most `limit`, from the one that follows the evaluation `after`.
    """
    table = schema.evaluations
    columns = [column for column in table.c if column.name != "arrays"]
    query = select(*columns).order_by(table.c.id.desc()).limit(limit)
    if after is not None:
        query = query.where(table.c.id < after)
    if scene is not None:
        query = query.where(table.c.scene == scene)
    with store.engine.connect() as connection:
        return [_record(row) for row in connection.execute(query)]


def find_evaluation(store: Store, number: int) -> tuple[EvaluationRecord, Comparison]:
    """The evaluation of that id, and its worlds. Raises NotFoundError, StorageError if damaged."""
    table = schema.evaluations
    row = None
    if 0 < number <= LARGEST_ID:
        with store.engine.connect() as connection:
            row = connection.execute(select(table).where(table.c.id == number)).one_or_none()
    if row is None:
        raise NotFoundError(f"There is no evaluation {number}; `evastudio evaluations` lists them.")
    record = _record(row)
    return record, Comparison.from_arrays(record.result, unpack(row.arrays, "evaluation"))


def differing(first: Comparison, second: Comparison) -> list[str]:
    """What differs, bit for bit, between two that should be the same; empty where nothing does."""
    ours, theirs = first.to_arrays(), second.to_arrays()
    names = [*first.pilots]
    found = []
    for key in sorted({*ours, *theirs}):
        same = (
            key in ours
            and key in theirs
            and np.array_equal(ours[key], theirs[key], equal_nan=ours[key].dtype.kind == "f")
        )
        if not same:
            pilot, _, what = key.partition(".")
            found.append(f"{names[int(pilot)]}: {what.removeprefix('figures.')}")
    return found


def _record(row: Row[Any]) -> EvaluationRecord:
    return EvaluationRecord(
        id=row.id,
        scene=row.scene,
        created_at=row.created_at,
        asked=json.loads(row.asked),
        versions=json.loads(row.versions),
        result=json.loads(row.result),
    )
