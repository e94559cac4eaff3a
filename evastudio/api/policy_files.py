"""Routes: policies and switches as files, taken, put and deleted."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Header, Request, Response, status
from starlette.exceptions import HTTPException

from evastudio.api.arrays import JSON
from evastudio.api.bodies import media_type, read_body, wrong_type
from evastudio.api.context import Context, Studio
from evastudio.api.downloads import BINARY, download, downloadable, matches
from evastudio.api.models.policies import PolicyOut
from evastudio.api.policies import described
from evastudio.errors import NotFoundError
from evastudio.learning.switch import MAX_BYTES as SWITCH_BYTES
from evastudio.learning.switch import SUFFIX as SWITCH

router = APIRouter(prefix="/policies", tags=["policies"])

BINARY_TYPE = "application/octet-stream"
MOST_BYTES = 256_000_000
IfMatch = Annotated[str | None, Header(max_length=200, description="ETag of the file meant.")]


@router.get(
    "/{name}/file",
    response_class=Response,
    responses=downloadable({BINARY_TYPE: BINARY, JSON: {"schema": {"type": "object"}}}),
)
def get_policy_file(name: str, request: Request, studio: Studio) -> Response:
    """The file of a policy, .safetensors, or of a switch, JSON."""
    path = studio.shelf.file(name)
    kind = JSON if path.name.endswith(SWITCH) else BINARY_TYPE
    etag = f'"{studio.shelf.digest(name)}"'
    return download(request, etag, path.name, kind, path.read_bytes)


async def _file(request: Request) -> tuple[bytes, bool]:
    """The body, and whether it is a switch's."""
    kind = media_type(request)
    if kind not in {BINARY_TYPE, JSON}:
        raise wrong_type(kind, BINARY_TYPE, JSON)
    switch = kind == JSON
    return await read_body(request, SWITCH_BYTES if switch else MOST_BYTES), switch


@router.put(
    "/{name}/file",
    max_body_size=MOST_BYTES,
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {BINARY_TYPE: BINARY, JSON: {"schema": {"type": "object"}}},
        }
    },
)
def put_policy_file(
    name: str,
    body: Annotated[tuple[bytes, bool], Depends(_file)],
    studio: Studio,
    if_match: IfMatch = None,
) -> PolicyOut:
    """Keep a policy's file as that name; a switch's where the body is JSON.

    It is read within bounds and never executed; what is no policy is refused. A name that is
    taken is 409 unless If-Match names the file to replace, and 412 where that is another by now.
    """
    data, switch = body
    _meant(studio, name, if_match)
    replaces = None if if_match is None else studio.shelf.digest(name)
    studio.shelf.put(name, data, switch=switch, replaces=replaces)
    return described(name, studio)


@router.delete("/{name}", status_code=status.HTTP_204_NO_CONTENT)
def delete_policy(name: str, studio: Studio, if_match: IfMatch = None) -> None:
    """Delete a policy or switch for good; the takes it was fitted to stay.

    One that is shipped stays (409), and so does one that a switch needs (409, naming it). Who
    plays it at this moment plays on.
    """
    _meant(studio, name, if_match)
    studio.shelf.remove(name)


def _meant(studio: Context, name: str, if_match: str | None) -> None:
    """Raise HTTPException 412 where `if_match` is given and names another file."""
    if if_match is None:
        return
    try:
        now = f'"{studio.shelf.digest(name)}"'
    except NotFoundError:
        now = ""
    if not now or not matches(if_match, now):
        raise HTTPException(412, f"{name[:80]!r} is not as If-Match says; look at it again.")
