"""Routes: runs and takes made into files that can be handed on, and those files."""

from __future__ import annotations

import asyncio
import os

from fastapi import APIRouter, Request, Response, status

from evastudio.api.context import Context, Studio
from evastudio.api.downloads import BINARY, TEXT, download_file, downloadable, etag_of
from evastudio.api.models.common import Page
from evastudio.api.models.films import FilmIn, FilmOut, TakeFilmIn
from evastudio.api.models.jobs import JobOut
from evastudio.api.paging import NamedPage
from evastudio.live import films
from evastudio.live.footage import Footage, take_footage

KINDS = {"html": "text/html; charset=utf-8", "mp4": "video/mp4"}

router = APIRouter(tags=["films"])


@router.post("/takes/{take}/film", status_code=status.HTTP_202_ACCEPTED)
def film_take(take: int, body: TakeFilmIn, studio: Studio) -> JobOut:
    """Make a take into a file; a job whose result names the film."""
    films.check(body.form, (body.width, body.height))
    footage = take_footage(studio.workspace, studio.store, take, body.camera)
    return _filming(footage, body, studio)


@router.post("/stages/{stage}/film", status_code=status.HTTP_202_ACCEPTED)
async def film_stage(stage: str, body: FilmIn, studio: Studio) -> JobOut:
    """Make what happened on a stage, or the take one looks at there, into a file; a job."""
    films.check(body.form, (body.width, body.height))
    found = studio.stages.get(stage)
    footage = await asyncio.to_thread(found.looking_back.footage)
    return _filming(footage, body, studio)


@router.get("/films")
def list_films(studio: Studio, paging: NamedPage) -> Page[FilmOut]:
    """The films kept, by name."""
    return paging.page(
        films.films(studio.workspace), lambda film: film.name, FilmOut.model_validate
    )


@router.get(
    "/films/{film}",
    response_class=Response,
    responses=downloadable({KINDS["html"]: TEXT, KINDS["mp4"]: BINARY}),
)
def get_film(film: str, request: Request, studio: Studio) -> Response:
    """A film as a file."""
    file = films.open_film(studio.workspace, film)
    told = os.fstat(file.fileno())
    etag = etag_of("film", film, told.st_size, told.st_mtime_ns)
    return download_file(request, etag, film, KINDS[film.rpartition(".")[2]], file)


@router.delete("/films/{film}", status_code=status.HTTP_204_NO_CONTENT)
def delete_film(film: str, studio: Studio) -> None:
    """Delete a film; what it shows stays."""
    films.forget_film(studio.workspace, film)


def _filming(footage: Footage, body: FilmIn, studio: Context) -> JobOut:
    job = studio.jobs.submit(
        "film",
        studio.film,
        workspace=studio.workspace,
        footage=footage,
        form=body.form,
        size=(body.width, body.height),
    )
    return JobOut.model_validate(job)
