"""Routes: why a character on a stage did what it did."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.reasons import MomentOut, WhyOut

router = APIRouter(prefix="/stages", tags=["stages"])


@router.get("/{stage}/why")
def get_why(stage: str, studio: Studio) -> WhyOut | None:
    """What the latest decision came from, or in a look back the one that is looked at.

    Null where no policy decided it.
    """
    found = studio.stages.get(stage)
    why = found.correcting.why()
    if why is None:
        return None
    names = found.scene.action.names
    return WhyOut(
        policy=why.policy,
        familiarity=why.familiarity,
        agreement=why.agreement,
        moments=[
            MomentOut(
                take=None if why.moments is None else int(why.moments[rank, 0]),
                step=None if why.moments is None else int(why.moments[rank, 1]),
                distance=float(why.distances[rank]),
                weight=float(why.weights[rank]),
                action=None
                if why.actions is None
                else dict(zip(names, why.actions[rank].tolist(), strict=True)),
            )
            for rank in range(len(why.pairs))
        ],
    )
