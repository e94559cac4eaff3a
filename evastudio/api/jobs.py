"""Routes: jobs."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Header, Response, status
from starlette.responses import StreamingResponse

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.jobs import JobOut
from evastudio.api.paging import NumberedPage
from evastudio.live.jobs import Job

router = APIRouter(prefix="/jobs", tags=["jobs"])


@router.get("")
def list_jobs(studio: Studio, paging: NumberedPage) -> Page[JobOut]:
    """Jobs since the server started, newest first."""

    def load(after: int | None, limit: int) -> list[Job]:
        older = [job for job in studio.jobs.all() if after is None or job.id < after]
        return older[:limit]

    return paging.page(JobOut, load)


EVENTS: dict[int | str, dict[str, object]] = {
    200: {
        "description": "Server-sent events, `change` or `end`, each with a job as it then was.",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}
LastEvent = Annotated[
    str | None, Header(alias="Last-Event-ID", max_length=80, description="The last event read.")
]


@router.get("/events", response_class=StreamingResponse, responses=EVENTS)
async def follow_jobs(studio: Studio, last_event_id: LastEvent = None) -> Response:
    """How jobs go on, as server-sent events: at first all as they stand, or what has changed since
    the event that Last-Event-ID names."""
    return _events(studio.job_feed.listen(last_event_id))


@router.get(
    "/{job}/events",
    response_class=StreamingResponse,
    responses={**EVENTS, 204: {"description": "Last-Event-ID names its end: no more will come."}},
)
async def follow_job(job: int, studio: Studio, last_event_id: LastEvent = None) -> Response:
    """How one job goes on, as server-sent events, until its end."""
    if studio.job_feed.is_over(studio.jobs.get(job), last_event_id):
        return Response(status_code=status.HTTP_204_NO_CONTENT)
    return _events(studio.job_feed.listen(last_event_id, only=job))


@router.get("/{job}")
def get_job(job: int, studio: Studio) -> JobOut:
    """How a job stands."""
    return JobOut.model_validate(studio.jobs.get(job))


@router.delete("/{job}")
def cancel_job(job: int, studio: Studio) -> JobOut:
    """End a job that waits or runs."""
    return JobOut.model_validate(studio.jobs.cancel(job))


@router.post("/{job}/again", status_code=status.HTTP_202_ACCEPTED)
def run_again(job: int, studio: Studio) -> JobOut:
    """Queue once more what an ended job was asked to do: a new job."""
    return JobOut.model_validate(studio.jobs.again(job))


def _events(told: AsyncIterator[str]) -> StreamingResponse:
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(told, media_type="text/event-stream", headers=headers)
