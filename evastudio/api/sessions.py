"""Routes: sessions and the work on them."""

from __future__ import annotations

import time

from fastapi import APIRouter, status

from evastudio.api.context import Studio
from evastudio.api.models.common import Given, Page
from evastudio.api.models.jobs import JobOut
from evastudio.api.models.sessions import (
    CleanIn,
    DiagnoseIn,
    FitIn,
    PlacesIn,
    PreviewIn,
    SessionIn,
    SessionOut,
    TuneIn,
)
from evastudio.api.paging import NumberedPage
from evastudio.demonstrations.records import SessionRecord
from evastudio.errors import InvalidInputError
from evastudio.learning.catalog import checked_policy_name, policy_name_from
from evastudio.learning.policy import find_learner
from evastudio.learning.tuning import AUTO
from evastudio.live import cleaning, headless
from evastudio.live.diagnosing import diagnose
from evastudio.live.jobs import Work
from evastudio.live.tuning import tune
from evastudio.live.visiting import find_places

router = APIRouter(tags=["sessions"])


@router.get("/sessions")
def list_sessions(
    studio: Studio, paging: NumberedPage, scene: str | None = None
) -> Page[SessionOut]:
    """Sessions, newest first; those of one scene where it is given."""
    return paging.page(
        SessionOut, lambda after, limit: studio.store.sessions(scene, after=after, limit=limit)
    )


@router.post("/sessions", status_code=status.HTTP_201_CREATED)
def create_session(body: SessionIn, studio: Studio) -> SessionOut:
    """A new, empty session."""
    scene = headless.make_scene(studio.workspace, body.scene)
    made = studio.store.create_session(scene, body.name, body.demonstrator, time.time())
    return SessionOut.model_validate(studio.store.session(made))


@router.get("/sessions/{session}")
def get_session(session: int, studio: Studio) -> SessionOut:
    """One session."""
    return SessionOut.model_validate(studio.store.session(session))


@router.post("/sessions/{session}/clean", status_code=status.HTTP_202_ACCEPTED)
def clean_session(session: int, body: CleanIn, studio: Studio) -> JobOut:
    """Mark the conflicts among the kept pairs; a job."""
    return _begin(studio, session, "clean", cleaning.clean, body)


@router.post("/sessions/{session}/clean/preview", status_code=status.HTTP_202_ACCEPTED)
def preview_cleaning(session: int, body: PreviewIn, studio: Studio) -> JobOut:
    """What cleaning would mark; a job whose result tells the worst in full. Nothing is kept."""
    return _begin(studio, session, "preview", cleaning.preview, body)


@router.delete("/sessions/{session}/clean")
def undo_cleaning(session: int, studio: Studio) -> SessionOut:
    """Take the latest cleaning back."""
    studio.store.session(session)
    studio.store.undo_cleaning(session)
    return SessionOut.model_validate(studio.store.session(session))


@router.post("/sessions/{session}/tune", status_code=status.HTTP_202_ACCEPTED)
def tune_session(session: int, body: TuneIn, studio: Studio) -> JobOut:
    """Try learners and settings on takes held out whole; a job whose result is the report."""
    return _begin(studio, session, "tune", tune, body)


@router.post("/sessions/{session}/places", status_code=status.HTTP_202_ACCEPTED)
def find_unvisited(session: int, body: PlacesIn, studio: Studio) -> JobOut:
    """Look where the kept takes do not come; a job whose result tells places.

    On a stage the command `visit` with a place's take, step and push begins a take there.
    """
    return _begin(studio, session, "places", find_places, body)


@router.post("/sessions/{session}/diagnose", status_code=status.HTTP_202_ACCEPTED)
def diagnose_session(session: int, body: DiagnoseIn, studio: Studio) -> JobOut:
    """Look for what would keep a policy from learning; a job whose result says what to do."""
    return _begin(studio, session, "diagnose", diagnose, body)


@router.post("/sessions/{session}/fit", status_code=status.HTTP_202_ACCEPTED)
def fit_session(session: int, body: FitIn, studio: Studio) -> JobOut:
    """Fit a policy to the kept pairs, without marked conflicts; a job.

    A name that is given may replace a policy. Without one it is called after its session, with a
    number behind it where another policy is called that.
    """
    record = _need_pairs(session, studio)
    scene = headless.make_scene(studio.workspace, record.scene)
    space = scene.chosen(scene.perception(body.perception))
    learner = AUTO if body.learner == AUTO else find_learner(body.learner, space)
    told = f"{record.name} {learner}"
    if body.perception not in (None, scene.perception().name):
        told += f" {body.perception}"
    name = checked_policy_name(body.name or policy_name_from(told))
    job = studio.jobs.submit(
        "fit",
        headless.fit,
        session,
        workspace=studio.workspace,
        learner=learner,
        perception=body.perception,
        settings=body.settings,
        delay=body.delay,
        name=name,
        beside=body.name is None,
    )
    return JobOut.model_validate(job)


def _begin(studio: Studio, session: int, kind: str, work: Work, body: Given) -> JobOut:
    """A job on the pairs of a session, as `body` asks for it."""
    _need_pairs(session, studio)
    asked = body.model_dump(exclude_none=True)
    job = studio.jobs.submit(kind, work, session, workspace=studio.workspace, **asked)
    return JobOut.model_validate(job)


def _need_pairs(session: int, studio: Studio) -> SessionRecord:
    record = studio.store.session(session)
    if record.pairs == 0:
        raise InvalidInputError(
            f"Session {record.name!r} has no pairs: no take is kept. Record a take first."
        )
    return record
