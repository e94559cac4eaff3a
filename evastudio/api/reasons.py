"""Routes: why a character on a stage did what it did."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.reasons import MomentOut, WhyOut
from evastudio.demonstrations.records import TakeRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import NotFoundError
from evastudio.pilots.why import Why

router = APIRouter(prefix="/stages", tags=["stages"])


@router.get("/{stage}/why")
def get_why(stage: str, studio: Studio) -> WhyOut | None:
    """What the latest decision came from, or in a look back the one that is looked at.

    Where a moment was left out since, what it would come from without. Null where no policy
    decided it.
    """
    found = studio.stages.get(stage)
    why = found.correcting.why()
    if why is None:
        return None
    names = found.scene.action.names
    moments = _moments(why, studio.store)
    return WhyOut(
        policy=why.policy,
        silent=found.correcting.silence(why),
        familiarity=why.familiarity,
        agreement=why.agreement,
        moments=[
            MomentOut(
                take=None if take is None else take.id,
                step=step,
                number=None if take is None else take.number,
                session=None if take is None else studio.store.session(take.session).name,
                seconds=None if step is None else step * found.scene.dt_s,
                distance=float(why.distances[rank]),
                weight=float(why.weights[rank]),
                action=None
                if why.actions is None
                else dict(zip(names, why.actions[rank].tolist(), strict=True)),
            )
            for rank, (take, step) in enumerate(moments)
        ],
    )


def _moments(why: Why, store: Store) -> list[tuple[TakeRecord | None, int | None]]:
    """Take and step of each moment, as far as `store` has it."""
    if why.moments is None or why.store != store.identity:
        return [(None, None)] * len(why.pairs)
    takes: dict[int, TakeRecord | None] = {}
    for take in dict.fromkeys(why.moments[:, 0].tolist()):
        try:
            takes[take] = store.take(take)
        except NotFoundError:  # thrown away for good
            takes[take] = None
    return [(takes[take], step) for take, step in why.moments.tolist()]
