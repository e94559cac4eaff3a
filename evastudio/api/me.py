"""Routes: who one is here."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.models.people import MeOut
from evastudio.api.people import Visitor

router = APIRouter(prefix="/me", tags=["access"])


@router.get("")
def get_me(visitor: Visitor) -> MeOut:
    """Who asks, and whether as an author or as a viewer."""
    return MeOut(name=visitor.name, role=visitor.role.value)
