"""Going on with a take where the store has it end: its last moment and what was done then."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import func, select

from evastudio.demonstrations import schema
from evastudio.demonstrations.packing import MOVING, unpack
from evastudio.demonstrations.rows import LARGEST_ID
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Unfinished:
    """A take as far as it is written."""

    id: int
    session: int
    scene_version: int
    seed: int
    options: Mapping[str, float]
    pilot: str
    perception: str
    closed: bool
    trashed: bool
    pairs: int
    last: tuple[Snapshot, Array] | None
    """The last moment and what was done then, (1, m) or that of all; None where there is none."""

    def moment(self, scene: Scene) -> Snapshot:
        """The moment that the next action of the take would answer."""
        if self.last is None:
            return scene.worlds([self.seed])
        return scene.step(*self.last)


def resume_take(store: Store, take: int) -> Unfinished:
    """A take, read no further back than needed. Raises NotFoundError and StorageError."""
    takes, chunks = schema.takes, schema.chunks
    row: Any = None
    last: Any = None
    pairs = 0
    if 0 < take <= LARGEST_ID:
        own = chunks.c.take_id == take
        with store.engine.connect() as connection:
            row = connection.execute(select(takes).where(takes.c.id == take)).one_or_none()
            pairs = connection.execute(
                select(func.coalesce(func.sum(chunks.c.steps), 0)).where(own)
            ).scalar_one()
            last = connection.execute(
                select(chunks.c.arrays).where(own).order_by(chunks.c.first_step.desc()).limit(1)
            ).scalar_one_or_none()
    if row is None:
        raise NotFoundError(f"There is no take {take}.")
    ended: tuple[Snapshot, Array] | None = None
    if last is not None:
        arrays = unpack(last, f"recording of take {take}")
        moving = {
            name.removeprefix(MOVING): array[-1:]
            for name, array in arrays.items()
            if name.startswith(MOVING)
        }
        ended = Snapshot(unpack(row.fixed, f"world of take {take}"), moving), arrays["actions"][-1:]
    return Unfinished(
        id=row.id,
        session=row.session_id,
        scene_version=row.scene_version,
        seed=row.seed,
        options=json.loads(row.options),
        pilot=row.pilot,
        perception=row.perception,
        closed=row.ended_at is not None,
        trashed=row.trashed_at is not None,
        pairs=int(pairs),
        last=ended,
    )


def written_actions(store: Store, take: int, first: int, steps: int) -> Array:
    """What was done in `steps` steps of a take from its step `first`, as far as it is written."""
    chunks = schema.chunks
    with store.engine.connect() as connection:
        rows = connection.execute(
            select(chunks.c.first_step, chunks.c.arrays)
            .where(
                chunks.c.take_id == take,
                chunks.c.first_step < first + steps,
                chunks.c.first_step + chunks.c.steps > first,
            )
            .order_by(chunks.c.first_step)
        ).all()
    begins = rows[0].first_step if rows else first
    parts = [unpack(row.arrays, f"recording of take {take}")["actions"] for row in rows]
    joined = np.concatenate(parts) if parts else np.empty((0, 0))
    return np.asarray(joined[first - begins : first - begins + steps])
