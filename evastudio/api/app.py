"""The API: its routes under one prefix."""

from __future__ import annotations

from fastapi import Depends, FastAPI

from evastudio.api import (
    asking,
    ballots,
    clips,
    conflicts,
    evaluations,
    failures,
    films,
    jobs,
    lineups,
    making,
    me,
    pairs,
    pilots,
    policies,
    policy_files,
    reasons,
    reviews,
    scenes,
    sessions,
    stages,
    studies,
    takes,
    walks,
    world_socket,
    worlds,
)
from evastudio.api.letters import plain_text

PREFIX = "/api/v1"
ROOMS = (
    me,
    scenes,
    sessions,
    conflicts,
    pairs,
    takes,
    policies,
    policy_files,
    pilots,
    asking,
    making,
    walks,
    evaluations,
    failures,
    studies,
    lineups,
    ballots,
    films,
    clips,
    jobs,
    stages,
    reasons,
    reviews,
    worlds,
    world_socket,
)


def add_routes(app: FastAPI) -> None:
    """Every route of the API. Each room by itself: nested routers are searched once a level."""
    for part in ROOMS:
        app.include_router(part.router, prefix=PREFIX, dependencies=[Depends(plain_text)])
