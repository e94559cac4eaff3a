"""Takes as they are told over HTTP, with the numbers of those they go on from."""

from __future__ import annotations

from collections.abc import Sequence

from evastudio.api.models.takes import OriginOut, TakeOut
from evastudio.demonstrations.records import TakeRecord
from evastudio.demonstrations.store import Store


def shown(records: Sequence[TakeRecord], store: Store) -> list[TakeOut]:
    """`records` of `store`, with where they come from in words a person knows."""
    origins = [one.origin.take for one in records if one.origin is not None]
    numbers = store.numbers(sorted({take for take in origins if take is not None}))
    return [
        TakeOut.model_validate({**vars(record), "origin": _origin(record, numbers)})
        for record in records
    ]


def _origin(record: TakeRecord, numbers: dict[int, int]) -> OriginOut | None:
    origin = record.origin
    if origin is None:
        return None
    dt_s = record.seconds / record.pairs if record.pairs else 0.0
    return OriginOut(
        step=origin.step,
        seconds=round(origin.step * dt_s, 6),
        take=origin.take,
        number=None if origin.take is None else numbers.get(origin.take),
        policy=origin.policy,
    )
