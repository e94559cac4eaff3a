"""Routes: looking back at what happened on a stage."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.reviews import StripOut

router = APIRouter(prefix="/stages", tags=["stages"])


@router.get("/{stage}/strip")
def get_strip(stage: str, studio: Studio) -> StripOut:
    """What there is to see along the run that is on a stage, or that is looked back at."""
    return StripOut.model_validate(studio.stages.get(stage).looking_back.strip())
