"""Routes: recordings of people walking, which sessions can be made of."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, status

from evastudio.api.bodies import media_type, read_body, wrong_type
from evastudio.api.context import Studio
from evastudio.api.downloads import TEXT
from evastudio.api.models.common import Page
from evastudio.api.models.walks import WalkFileOut
from evastudio.api.paging import NamedPage
from evastudio.demonstrations.walks import MOST_BYTES, RATES_HZ
from evastudio.live.walk_files import forget_walks, keep_walks, walk_files

router = APIRouter(prefix="/walks", tags=["making"])

KINDS = ("text/plain", "text/csv")


@router.get("")
def list_walks(studio: Studio, paging: NamedPage) -> Page[WalkFileOut]:
    """The recordings at hand, by name."""
    return paging.page(walk_files(studio.workspace), lambda path: path.name, _told)


async def _table(request: Request) -> bytes:
    kind = media_type(request)
    if kind not in KINDS:
        raise wrong_type(kind, *KINDS)
    return await read_body(request, MOST_BYTES)


@router.put(
    "/{name}",
    max_body_size=MOST_BYTES,
    openapi_extra={
        "requestBody": {"required": True, "content": {kind: dict(TEXT) for kind in KINDS}}
    },
)
def put_walks(
    name: str,
    data: Annotated[bytes, Depends(_table)],
    studio: Studio,
    fps: Annotated[float | None, Query(ge=RATES_HZ[0], le=RATES_HZ[1])] = None,
) -> WalkFileOut:
    """Keep a table of frame, person, x and y in metres as that name, .txt or .csv.

    It is read within bounds; what is no recording is refused. One of that name is replaced.
    """
    return _told(keep_walks(studio.workspace, name, data, fps))


@router.delete("/{name}", status_code=status.HTTP_204_NO_CONTENT)
def delete_walks(name: str, studio: Studio) -> None:
    """Delete a recording; sessions made of it stay."""
    forget_walks(studio.workspace, name)


def _told(path: Path) -> WalkFileOut:
    return WalkFileOut(name=path.name, bytes=path.stat().st_size)
