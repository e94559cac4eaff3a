"""Studies of people: how long they were taught, how long they demonstrated, what they preferred."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from sqlalchemy import insert, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.engine import writing
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError


@dataclass(frozen=True)
class Study:
    """One person at one scene, as in the paper's table 3."""

    scene: str
    person: str
    """What they do: 'artist'. No name."""
    instructed_s: float | None
    """How long they were taught; None for somebody who knew the studio."""
    demonstrated_s: float
    preferred: str | None = None
    """The pilot whose way of moving they preferred; None where they were not asked."""

    def __post_init__(self) -> None:
        for name in ("instructed_s", "demonstrated_s"):
            seconds = getattr(self, name)
            if seconds is not None and not 0.0 <= seconds < 1e6:
                raise InvalidInputError(
                    f"{name} of a study is {seconds!r}; give seconds, from 0 on."
                )


def save_study(store: Store, study: Study, now: float) -> int:
    """Keep `study`; its id. `now` in seconds since the epoch."""
    with writing(store.engine) as connection:
        made = connection.execute(
            insert(schema.studies).values(
                scene=study.scene, created_at=now, told=json.dumps(asdict(study), allow_nan=False)
            )
        )
    return int((made.inserted_primary_key or (0,))[0])


def studies(store: Store) -> list[Study]:
    """Every study kept, in the order in which they were made."""
    table = schema.studies
    with store.engine.connect() as connection:
        rows = connection.execute(select(table.c.told).order_by(table.c.id)).scalars().all()
    return [Study(**json.loads(told)) for told in rows]
