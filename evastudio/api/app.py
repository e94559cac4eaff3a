"""The API: its routes under one prefix."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api import clips, evaluations, jobs, policies, scenes, sessions, stages, takes

PREFIX = "/api/v1"


def api_router() -> APIRouter:
    """Every route of the API."""
    router = APIRouter(prefix=PREFIX)
    for part in (scenes, sessions, takes, policies, evaluations, clips, jobs, stages):
        router.include_router(part.router)
    return router
