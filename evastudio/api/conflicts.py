"""Routes: what cleaning would leave out of a session and why, and what people say of it."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, status

from evastudio.api.context import Studio
from evastudio.api.models.conflicts import (
    Threshold,
    VerdictIn,
    VerdictOut,
    VerdictsOut,
)
from evastudio.errors import NotFoundError
from evastudio.live.weighing import Compared, Weighing, compared, weigh

router = APIRouter(prefix="/sessions/{session}", tags=["sessions"])


@router.get("/conflicts")
def list_conflicts(
    session: int,
    studio: Studio,
    threshold: Threshold = "auto",
    limit: Annotated[int, Query(ge=0, le=1000)] = 50,
) -> Weighing | None:
    """What cleaning at that threshold would leave out, by what the latest look found; null where
    nobody has looked.

    A look is a job, `POST /sessions/{session}/clean/preview`; after it any threshold is answered in
    a moment.
    """
    record = studio.store.session(session)
    try:
        return weigh(studio.workspace, studio.store, record, threshold, limit)
    except NotFoundError:
        return None


@router.get("/conflicts/{take}/{step}")
def get_conflict(
    session: int, take: int, step: int, studio: Studio, threshold: Threshold = "auto"
) -> Compared:
    """One pair beside those that it was compared with, conflict or not."""
    record = studio.store.session(session)
    return compared(studio.workspace, studio.store, record, take, step, threshold)


@router.get("/verdicts")
def list_verdicts(session: int, studio: Studio) -> VerdictsOut:
    """What was said of single pairs of the kept takes."""
    studio.store.session(session)
    said = studio.store.verdicts(session)
    return VerdictsOut(
        items=[
            VerdictOut(take=take, step=step, verdict=verdict)
            for (take, step), verdict in said.items()
        ]
    )


@router.put("/verdicts/{take}/{step}")
def put_verdict(session: int, take: int, step: int, body: VerdictIn, studio: Studio) -> VerdictOut:
    """Say of a pair whether it is kept or deleted, or that something is missing there."""
    _need_take(session, take, studio)
    studio.store.judge(take, step, body.verdict)
    return VerdictOut(take=take, step=step, verdict=body.verdict)


@router.delete("/verdicts/{take}/{step}", status_code=status.HTTP_204_NO_CONTENT)
def delete_verdict(session: int, take: int, step: int, studio: Studio) -> None:
    """Say nothing of a pair any more."""
    _need_take(session, take, studio)
    studio.store.judge(take, step, None)


def _need_take(session: int, take: int, studio: Studio) -> None:
    record = studio.store.session(session)
    if studio.store.take(take).session != session:
        raise NotFoundError(f"Session {record.name!r} has no take {take}.")
