"""Routes: where a policy fails. A job."""

from __future__ import annotations

from fastapi import APIRouter, status

from evastudio.api.context import Studio
from evastudio.api.models.failures import FailuresIn
from evastudio.api.models.jobs import JobOut
from evastudio.live.failing import find_failures
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot, scene_of

router = APIRouter(tags=["evaluations"])


@router.post("/failures", status_code=status.HTTP_202_ACCEPTED)
def start_failures(body: FailuresIn, studio: Studio) -> JobOut:
    """Fly a policy through new worlds until enough of them fail; a job whose result tells when.

    Where none fails, the closest calls. `play` with that seed and second goes there on a stage.
    """
    name = body.scene or scene_of(studio.workspace, [body.policy])
    scene = make_scene(studio.workspace, name, body.options)
    load_pilot(studio.workspace, body.policy, scene)
    given = {**body.model_dump(), "scene": name}
    job = studio.jobs.submit("failures", find_failures, workspace=studio.workspace, **given)
    return JobOut.model_validate(job)
