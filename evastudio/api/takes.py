"""Routes: takes, made by a program step by step, thrown away, brought back and read."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Depends, Query, Request, Response, status

from evastudio.api.arrays import JSON, NPZ, as_json, npz
from evastudio.api.bodies import body_of, model_or_arrays
from evastudio.api.context import Context, Studio
from evastudio.api.downloads import BINARY, TEXT, download, downloadable, etag_of
from evastudio.api.limits import MOST_UPLOAD_BYTES
from evastudio.api.models.common import Page
from evastudio.api.models.takes import (
    ActionsIn,
    EmptiedOut,
    NoteIn,
    RemarkedOut,
    RemarkOut,
    RemarksOut,
    StandingOut,
    TakeIn,
    TakeOut,
)
from evastudio.api.paging import NumberedPage
from evastudio.api.shown_takes import shown
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.live import enacting
from evastudio.live.thumbnail import DRAWING
from evastudio.world.snapshot import AnyArray

router = APIRouter(tags=["takes"])

SVG = "image/svg+xml"
RecordingForm = Annotated[Literal["json", "npz"], Query(alias="format")]


@router.get("/sessions/{session}/takes")
def list_takes(
    session: int,
    studio: Studio,
    paging: NumberedPage,
    trashed: bool | None = None,
    newest: bool = False,
) -> Page[TakeOut]:
    """Its takes in order: all of them, or only kept or trashed ones; the newest first if wanted."""
    store = studio.store
    store.session(session)
    return paging.page(
        TakeOut,
        lambda after, limit: shown(
            store.takes(session, trashed, after=after, limit=limit, newest=newest), store
        ),
    )


@router.get("/sessions/{session}/remarks")
def list_remarks(session: int, studio: Studio) -> RemarksOut:
    """Which of its newest takes are suspicious, and why, in words for people."""
    found = studio.reviewing.remarks(session)
    return RemarksOut(
        items=[
            RemarkedOut(
                take=take,
                remarks=[RemarkOut.model_validate(one) for one in remarks],
            )
            for take, remarks in found.items()
        ]
    )


@router.post("/sessions/{session}/takes", status_code=status.HTTP_201_CREATED)
def begin_take(session: int, body: TakeIn, studio: Studio) -> StandingOut:
    """A new take in a world of its own, for a program to act in."""
    told = enacting.begin_take(
        studio.workspace,
        studio.store,
        session,
        body.pilot,
        time.time(),
        seed=body.seed,
        options=body.options,
        perception=body.perception,
    )
    return StandingOut.model_validate(told)


@router.delete("/sessions/{session}/trash")
def empty_trash(session: int, studio: Studio) -> EmptiedOut:
    """Delete the trashed takes of a session for good. Nothing else deletes a take."""
    studio.store.session(session)
    emptied = studio.store.empty_trash(session)
    _refresh(studio)
    return EmptiedOut(takes=emptied)


@router.get("/takes/{take}")
def get_take(take: int, studio: Studio) -> TakeOut:
    """One take."""
    return _shown(take, studio)


@router.put("/takes/{take}/note")
def note_take(take: int, body: NoteIn, studio: Studio) -> TakeOut:
    """Note something about a take, in place of what was noted before."""
    studio.store.note_take(take, body.note)
    return _shown(take, studio)


@router.get(
    "/takes/{take}/thumbnail.svg",
    response_class=Response,
    responses=downloadable({SVG: TEXT}),
)
def get_thumbnail(take: int, request: Request, studio: Studio) -> Response:
    """The way that was gone in it, seen from above."""
    record = studio.store.take(take)
    etag = etag_of("thumbnail", DRAWING, studio.store.identity, take, record.pairs, record.outcome)
    content = studio.reviewing.thumbnail
    return download(request, etag, f"take-{take}.svg", SVG, lambda: content(record))


async def _actions(request: Request) -> ActionsIn | dict[str, AnyArray]:
    return await model_or_arrays(request, ActionsIn)


@router.post(
    "/takes/{take}/actions",
    max_body_size=MOST_UPLOAD_BYTES,
    openapi_extra=body_of(ActionsIn, {"first_step": 0, "actions": [[0.05, 0.0], [0.05, 0.0]]}),
)
def append_actions(
    take: int, body: Annotated[ActionsIn | dict[str, AnyArray], Depends(_actions)], studio: Studio
) -> StandingOut:
    """Do these actions in the take's world, one a decision step, and write what happens.

    The studio steps the world: states, snapshots and outcome are computed, so the take replays.
    All are written or none. The same actions of the same steps may be sent again; a gap, or other
    actions for steps that are written, is 409. As npz: `first_step`, `actions` and, optionally,
    `states`.
    """
    first_step, actions, states = _unpacked(body)
    told = enacting.append_actions(
        studio.workspace, studio.store, take, first_step, actions, time.time(), states
    )
    return StandingOut.model_validate(told)


@router.post("/takes/{take}/close")
def close_take(take: int, studio: Studio) -> StandingOut:
    """End a program's take. How its world ended is computed; none where it had not."""
    told = enacting.close_take(studio.workspace, studio.store, take, time.time())
    return StandingOut.model_validate(told)


@router.post("/takes/{take}/trash")
def trash_take(take: int, studio: Studio) -> TakeOut:
    """Leave a take out until it is restored."""
    studio.store.trash_take(take, time.time())
    return _changed(take, studio)


@router.post("/takes/{take}/restore")
def restore_take(take: int, studio: Studio) -> TakeOut:
    """Bring a take back."""
    studio.store.restore_take(take)
    return _changed(take, studio)


@router.get(
    "/takes/{take}/recording",
    response_class=Response,
    responses=downloadable(
        {JSON: {"schema": {"$ref": "#/components/schemas/RecordingOut"}}, NPZ: BINARY}
    ),
)
def get_recording(
    take: int, request: Request, studio: Studio, form: RecordingForm = "json"
) -> Response:
    """What was recorded: states, actions in the world's frame and, as npz, all snapshots.

    The npz holds `states`, `actions`, and the snapshots' arrays as `fixed.NAME`, one world, and
    `moving.NAME`, one row a step.
    """
    record = studio.store.take(take)

    def content() -> bytes:
        data = studio.store.load_take(take)
        arrays: dict[str, AnyArray] = {"states": data.states, "actions": data.actions}
        if form == "json":
            return as_json({"take": take, "seed": record.seed, **arrays})
        shared = {f"fixed.{name}": one[:1] for name, one in data.snapshots.fixed.items()}
        steps = {f"moving.{name}": one for name, one in data.snapshots.moving.items()}
        return npz({**arrays, **shared, **steps})

    etag = etag_of(
        "recording", studio.store.identity, take, record.seed, record.origin, record.pairs, form
    )
    kind = JSON if form == "json" else NPZ
    return download(request, etag, f"take-{take}.{form}", kind, content)


def _unpacked(body: ActionsIn | Mapping[str, AnyArray]) -> tuple[int, AnyArray, AnyArray | None]:
    """The first step, the actions and, where they are given, the states."""
    if isinstance(body, ActionsIn):
        try:
            actions = np.array(body.actions, dtype=np.float64)
            states = None if body.states is None else np.array(body.states, dtype=np.float64)
        except ValueError:
            raise InvalidInputError(
                "The rows of actions, or of states, differ in length."
            ) from None
        return body.first_step, actions, states
    missing = {"first_step", "actions"} - body.keys()
    unknown = body.keys() - {"first_step", "actions", "states"}
    if missing or unknown:
        raise InvalidInputError(
            f"The arrays are {', '.join(sorted(body)) or 'none'}; expected first_step, actions and "
            "at most states beside them."
        )
    first = body["first_step"]
    if first.size != 1 or first.dtype.kind not in "iu" or not 0 <= int(first.reshape(())) < 2**31:
        raise InvalidInputError("first_step is not one whole number from 0; send one.")
    return int(first.reshape(())), np.asarray(body["actions"], np.float64), body.get("states")


def _changed(take: int, studio: Studio) -> TakeOut:
    _refresh(studio)
    return _shown(take, studio)


def _shown(take: int, studio: Context) -> TakeOut:
    (found,) = shown([studio.store.take(take)], studio.store)
    return found


def _refresh(studio: Context) -> None:
    """Let every stage count its session's takes anew."""
    for stage in studio.stages.all():
        with contextlib.suppress(ConflictError):  # it closes at this moment
            stage.refresh()
