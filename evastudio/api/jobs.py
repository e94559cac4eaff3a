"""Routes: jobs."""

from __future__ import annotations

from fastapi import APIRouter

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.jobs import JobOut

router = APIRouter(prefix="/jobs", tags=["jobs"])


@router.get("")
def list_jobs(studio: Studio) -> Page[JobOut]:
    """Jobs since the server started, newest first."""
    return Page(items=[JobOut.model_validate(job) for job in studio.jobs.all()])


@router.get("/{job}")
def get_job(job: int, studio: Studio) -> JobOut:
    """How a job stands."""
    return JobOut.model_validate(studio.jobs.get(job))


@router.delete("/{job}")
def cancel_job(job: int, studio: Studio) -> JobOut:
    """End a job that waits or runs."""
    return JobOut.model_validate(studio.jobs.cancel(job))
