"""Routes: who can act in a scene."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.evaluations import PilotOut
from evastudio.api.paging import NamedPage
from evastudio.live.headless import make_scene
from evastudio.live.piloting import pilots_for

router = APIRouter(prefix="/pilots", tags=["pilots"])


@router.get("")
def list_pilots(scene: str, studio: Studio, paging: NamedPage) -> Page[PilotOut]:
    """The policies made for a scene as it is now, the user's own first, and the programs."""
    place = make_scene(studio.workspace, scene)
    return paging.page(
        pilots_for(studio.workspace, place), lambda one: one.name, PilotOut.model_validate
    )
