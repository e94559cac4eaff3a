"""Evaluations in the session store: what was asked, under which versions, and every world's end."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Row

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.packing import pack, unpack
from evastudio.demonstrations.rows import newest_first, put_in, row_at
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError
from evastudio.evaluation.results import SUCCESS, Comparison
from evastudio.evaluation.versions import versions
from evastudio.evaluation.words import in_words, label


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

    @property
    def says(self) -> list[str]:
        """Of each pair of pilots what was found, in words."""
        return in_words(self.result)

    @property
    def labels(self) -> dict[str, str]:
        """What people call each figure, by its name."""
        figures = [name for one in self.result["pilots"].values() for name in one["figures"]]
        names = dict.fromkeys((SUCCESS, *figures, "unlike", "decision_us"))
        unlike = {"unlike": f"Unlike {self.result['like']}, %"}
        return {name: label(name) for name in names} | unlike

    @property
    def mark(self) -> str:
        """Tells it from every other evaluation, of whatever store; hexadecimal."""
        told = [self.id, self.created_at, dict(self.asked), dict(self.versions), dict(self.result)]
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def save_evaluation(
    store: Store, comparison: Comparison, asked: Mapping[str, Any], now: float
) -> int:
    """Keep `comparison`; its id. `now` in seconds since the epoch."""
    with writing(store.engine) as connection:
        return put_in(
            connection,
            schema.evaluations,
            scene=comparison.scene["name"],
            created_at=now,
            asked=json.dumps(dict(asked)),
            versions=json.dumps(versions()),
            result=json.dumps(comparison.to_json(), allow_nan=False),
            arrays=pack(comparison.to_arrays()),
        )


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
    query = newest_first(schema.evaluations, scene, after, limit, _TOLD)
    with store.engine.connect() as connection:
        return [_record(row) for row in connection.execute(query)]


def find_evaluation(store: Store, number: int) -> tuple[EvaluationRecord, Comparison]:
    """The evaluation of that id, and its worlds. Raises NotFoundError, StorageError if damaged."""
    row = _row(store, number)
    record = _record(row)
    return record, Comparison.from_arrays(record.result, unpack(row.arrays, "evaluation"))


def find_record(store: Store, number: int) -> EvaluationRecord:
    """The same without its worlds. Raises NotFoundError."""
    return _record(_row(store, number, _TOLD))


def beside(
    record: EvaluationRecord, records: Iterable[EvaluationRecord]
) -> tuple[str, dict[float, EvaluationRecord]] | None:
    """The option in which others of `records` differ from `record`, and they by its value.

    They are of the same files in worlds of the same seed, as many; of two at one value the newer,
    but `record` itself. Where several options have been tried, it is the one with most values;
    None where there is no other.
    """
    here = record.asked["options"]
    alike = [one for one in records if _question(one) == _question(record)]
    found: dict[str, dict[float, EvaluationRecord]] = {name: {} for name in here}
    for one in sorted([*alike, record], key=lambda one: (one.id == record.id, one.id)):
        there = one.asked["options"]
        changed = [name for name in here if there.get(name) != here[name]]
        for name in here if not changed else changed if len(changed) == 1 else ():
            found[name][there[name]] = one
    most = max(found, key=lambda name: len(found[name]), default=None)
    if most is None or len(found[most]) < 2:
        return None
    return most, dict(sorted(found[most].items()))


def _question(record: EvaluationRecord) -> tuple[Any, ...]:
    asked = record.asked
    version = record.result["scene"]["version"]
    return record.scene, version, asked["policies"], asked["worlds"], asked["seed"]


_TOLD = [column for column in schema.evaluations.c if column.name != "arrays"]


def _row(store: Store, number: int, columns: Iterable[Any] | None = None) -> Row[Any]:
    row = row_at(store.engine, schema.evaluations, number, columns)
    if row is None:
        raise NotFoundError(f"There is no evaluation {number}; `evastudio evaluations` lists them.")
    return row


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
