"""Routes: evaluations, pilots compared on the same worlds."""

from __future__ import annotations

from fastapi import APIRouter, status

from evastudio.api.context import Studio
from evastudio.api.models.common import Page
from evastudio.api.models.evaluations import EvaluateIn, EvaluationOut
from evastudio.api.models.jobs import JobOut
from evastudio.evaluation import archive
from evastudio.live.evaluating import evaluate
from evastudio.live.headless import make_scene
from evastudio.live.piloting import load_pilot

router = APIRouter(prefix="/evaluations", tags=["evaluations"])


@router.post("", status_code=status.HTTP_202_ACCEPTED)
def start_evaluation(body: EvaluateIn, studio: Studio) -> JobOut:
    """Fly policies through the same new worlds; a job whose result is the comparison."""
    scene = make_scene(studio.workspace, body.scene, body.options)
    for name in body.policies:
        load_pilot(studio.workspace, name, scene)
    job = studio.jobs.submit("evaluate", evaluate, workspace=studio.workspace, **body.model_dump())
    return JobOut.model_validate(job)


@router.get("")
def list_evaluations(studio: Studio, scene: str | None = None) -> Page[EvaluationOut]:
    """Evaluations kept, newest first; those of one scene where it is given."""
    found = archive.evaluations(studio.store, scene)
    return Page(items=[EvaluationOut.model_validate(record) for record in found])


@router.get("/{evaluation}")
def get_evaluation(evaluation: int, studio: Studio) -> EvaluationOut:
    """One evaluation."""
    record, _ = archive.find_evaluation(studio.store, evaluation)
    return EvaluationOut.model_validate(record)
