"""Routes: evaluations, pilots compared on the same worlds."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response, status

from evastudio.api.arrays import NPZ, npz
from evastudio.api.context import Studio
from evastudio.api.downloads import BINARY, download, downloadable, etag_of
from evastudio.api.models.common import Page
from evastudio.api.models.evaluations import (
    DisputedOut,
    EvaluateIn,
    EvaluationOut,
    PictureOut,
    PicturesOut,
)
from evastudio.api.models.jobs import JobOut
from evastudio.api.paging import NumberedPage
from evastudio.evaluation import archive, pictures
from evastudio.live.evaluating import evaluate, repeat_evaluation
from evastudio.live.headless import make_scene
from evastudio.live.picturing import TITLES, draw_pictures, kept_pictures, picture_file
from evastudio.live.piloting import load_pilot

MOST_TOLD = 100
"""Of the worlds that ended differently."""
FORMS = {"svg": "image/svg+xml", "png": "image/png"}

router = APIRouter(prefix="/evaluations", tags=["evaluations"])


@router.post("", status_code=status.HTTP_202_ACCEPTED)
def start_evaluation(body: EvaluateIn, studio: Studio) -> JobOut:
    """Fly policies through the same new worlds; a job whose result is the comparison."""
    scene = make_scene(studio.workspace, body.scene, body.options)
    for name in body.policies:
        load_pilot(studio.workspace, name, scene)
    if body.like_session is not None:
        studio.store.session(body.like_session)
    job = studio.jobs.submit("evaluate", evaluate, workspace=studio.workspace, **body.model_dump())
    return JobOut.model_validate(job)


@router.get("")
def list_evaluations(
    studio: Studio, paging: NumberedPage, scene: str | None = None
) -> Page[EvaluationOut]:
    """Evaluations kept, newest first; those of one scene where it is given."""
    return paging.page(
        EvaluationOut,
        lambda after, limit: archive.evaluations(studio.store, scene, after=after, limit=limit),
    )


@router.get("/{evaluation}/arrays", response_class=Response, responses=downloadable({NPZ: BINARY}))
def get_arrays(evaluation: int, request: Request, studio: Studio) -> Response:
    """Every world's figures, as npz: `NUMBER.NAME` for the pilots in the order of the result."""
    record, compared = archive.find_evaluation(studio.store, evaluation)
    etag = etag_of("evaluation", studio.store.identity, evaluation, record.created_at)
    name = f"evaluation-{evaluation}.npz"
    return download(request, etag, name, NPZ, lambda: npz(compared.to_arrays()))


@router.get("/{evaluation}")
def get_evaluation(evaluation: int, studio: Studio) -> EvaluationOut:
    """One evaluation."""
    return EvaluationOut.model_validate(archive.find_record(studio.store, evaluation))


@router.get("/{evaluation}/disputed")
def list_disputed(evaluation: int, studio: Studio) -> DisputedOut:
    """The worlds that ended well for some of the pilots and not for others: those to look at."""
    worlds = archive.find_evaluation(studio.store, evaluation)[1].disputed()
    return DisputedOut(worlds=worlds[:MOST_TOLD], count=len(worlds))


@router.post("/{evaluation}/again", status_code=status.HTTP_202_ACCEPTED)
def repeat(evaluation: int, studio: Studio) -> JobOut:
    """Make an evaluation again; a job whose result names what differs, bit for bit."""
    archive.find_record(studio.store, evaluation)
    job = studio.jobs.submit(
        "again", repeat_evaluation, workspace=studio.workspace, number=evaluation
    )
    return JobOut.model_validate(job)


@router.get("/{evaluation}/pictures")
def list_pictures(evaluation: int, studio: Studio, request: Request) -> PicturesOut:
    """The pictures of an evaluation that are drawn."""
    kept = kept_pictures(studio.workspace, studio.store, evaluation)

    def path(file: str) -> str:
        return str(request.app.url_path_for("get_picture", evaluation=evaluation, file=file))

    items = [
        PictureOut(name=name, title=TITLES[name], svg=path(f"{name}.svg"), png=path(f"{name}.png"))
        for name in kept.names
    ]
    return PicturesOut(items=items, left_out=kept.left_out, whole=kept.whole)


@router.post("/{evaluation}/pictures", status_code=status.HTTP_202_ACCEPTED)
def start_drawing(evaluation: int, studio: Studio) -> JobOut:
    """Draw the pictures of an evaluation; a job. They are kept."""
    archive.find_record(studio.store, evaluation)
    pictures.ready()
    job = studio.jobs.submit(
        "pictures", draw_pictures, workspace=studio.workspace, evaluation=evaluation
    )
    return JobOut.model_validate(job)


@router.get(
    "/{evaluation}/pictures/{file}",
    response_class=Response,
    responses=downloadable(dict.fromkeys(FORMS.values(), BINARY)),
)
def get_picture(evaluation: int, file: str, request: Request, studio: Studio) -> Response:
    """A picture as a file: its name, then .svg or .png."""
    content = picture_file(studio.workspace, studio.store, evaluation, file).read_bytes()
    # As a download: opened by itself an SVG would be a page of this origin.
    name = f"evaluation-{evaluation}-{file}"
    media_type = FORMS[file.rpartition(".")[2]]
    return download(request, etag_of(name, content), name, media_type, lambda: content)
