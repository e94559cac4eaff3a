"""Routes: headless worlds, in which another program demonstrates, plays or tries."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Mapping
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Query, Request, Response, status

from evastudio.api.arrays import JSON, NPZ, as_json, npz, read_npz
from evastudio.api.bodies import body_of, media_type, model_or_arrays, read_body, wrong_type
from evastudio.api.context import Context, Studio
from evastudio.api.downloads import BINARY
from evastudio.api.limits import MOST_UPLOAD_BYTES
from evastudio.api.models.common import Page
from evastudio.api.models.worlds import (
    DemonstratingOut,
    PlayIn,
    ResetIn,
    SeenOut,
    StepIn,
    WorldsIn,
    WorldsOut,
)
from evastudio.api.paging import NamedPage
from evastudio.errors import InvalidInputError, StudioError
from evastudio.live.batch import MOST_BYTES, Batch
from evastudio.live.saved import Saved
from evastudio.live.stepping import Seen
from evastudio.live.worlds import IDLE_S
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Space, Symbols

router = APIRouter(prefix="/worlds", tags=["worlds"])

Form = Annotated[Literal["json", "npz"], Query(alias="format")]
Frame = Annotated[
    Literal["world", "own"],
    Query(description="Whose frame actions are in: the world's, or that of policies' decisions."),
]
SEEN: dict[int | str, dict[str, object]] = {
    200: {"description": "How the worlds are now.", "content": {NPZ: BINARY}}
}


@router.post("", status_code=status.HTTP_201_CREATED)
async def open_worlds(body: WorldsIn, studio: Studio) -> WorldsOut:
    """New worlds, one for each seed. They close themselves when nobody asks for them any more."""
    batch = await asyncio.to_thread(studio.worlds.open, **body.model_dump())
    studio.background(_close_when_idle(batch, studio))
    return _described(batch)


@router.get("")
def list_worlds(studio: Studio, paging: NamedPage) -> Page[WorldsOut]:
    """The batches that are open, the first opened first."""
    return paging.page(studio.worlds.all(), lambda batch: batch.name, _described)


@router.get("/{worlds}")
def get_worlds(worlds: str, studio: Studio) -> WorldsOut:
    """What a batch is of."""
    return _described(studio.worlds.get(worlds))


@router.get("/{worlds}/state", response_model=SeenOut, responses=SEEN)
def observe_worlds(worlds: str, studio: Studio, form: Form = "json") -> Response:
    """How the worlds are now. As npz the arrays `states`, `outcomes` (codes), `progress`, `steps`;
    so too where else worlds are told."""
    batch = studio.worlds.get(worlds)
    return _told(batch, batch.observe(), form)


@router.post("/{worlds}/reset", response_model=SeenOut, responses=SEEN)
def reset_worlds(worlds: str, body: ResetIn, studio: Studio, form: Form = "json") -> Response:
    """New worlds in place of those there are, of any number; a running take is kept as it is."""
    batch = studio.worlds.get(worlds)
    return _told(batch, batch.reset(body.seeds), form)


async def _step_body(request: Request) -> StepIn | dict[str, AnyArray]:
    return await model_or_arrays(request, StepIn)


@router.post(
    "/{worlds}/step",
    max_body_size=MOST_UPLOAD_BYTES,
    response_model=SeenOut,
    responses=SEEN,
    openapi_extra=body_of(StepIn, {"actions": [[0.05, 0.0]]}),
)
def step_worlds(
    worlds: str,
    body: Annotated[StepIn | dict[str, AnyArray], Depends(_step_body)],
    studio: Studio,
    frame: Frame = "world",
    form: Form = "json",
) -> Response:
    """One decision in every world, or several one after another. As npz: `actions`."""
    batch = studio.worlds.get(worlds)
    if isinstance(body, Mapping) and set(body) != {"actions"}:
        raise InvalidInputError(
            f"The arrays are {', '.join(sorted(body)) or 'none'}; expected actions alone."
        )
    actions = body["actions"] if isinstance(body, Mapping) else body.actions
    return _told(batch, batch.step(actions, own=frame == "own"), form)


@router.post("/{worlds}/play", response_model=SeenOut, responses=SEEN)
def play_worlds(worlds: str, body: PlayIn, studio: Studio, form: Form = "json") -> Response:
    """Let a policy, or another pilot of the studio, decide for some steps; none is recorded."""
    batch = studio.worlds.get(worlds)
    return _told(batch, batch.play(body.pilot, body.steps), form)


@router.get(
    "/{worlds}/snapshot",
    response_class=Response,
    responses={200: {"description": "The snapshot.", "content": {NPZ: BINARY}}},
)
def save_worlds(worlds: str, studio: Studio, fixed: bool = False) -> Response:
    """Everything about the worlds now, to go on from: `moving.NAME` of the snapshot, `seeds`,
    `steps`, what a pilot that plays remembers, and what it is all about.

    With `fixed` also what never changes in a world, `fixed.NAME`: it follows from the seeds.
    """
    batch = studio.worlds.get(worlds)
    named = {"Content-Disposition": f'attachment; filename="worlds-{batch.name}.npz"'}
    return Response(npz(batch.save().arrays(fixed=fixed)), media_type=NPZ, headers=named)


async def _snapshot_body(request: Request) -> bytes:
    if media_type(request) != NPZ:
        raise wrong_type(media_type(request), NPZ)
    return await read_body(request, MOST_BYTES)


@router.put(
    "/{worlds}/snapshot",
    max_body_size=MOST_UPLOAD_BYTES,
    response_model=SeenOut,
    responses=SEEN,
    openapi_extra={"requestBody": {"required": True, "content": {NPZ: BINARY}}},
)
def restore_worlds(
    worlds: str,
    body: Annotated[bytes, Depends(_snapshot_body)],
    studio: Studio,
    form: Form = "json",
) -> Response:
    """Go on from a snapshot as it was downloaded, of worlds of the same scene and options.

    What the program does from there on is a take that begins there.
    """
    batch = studio.worlds.get(worlds)
    return _told(batch, batch.restore(Saved.of(read_npz(body, MOST_BYTES))), form)


@router.delete("/{worlds}", status_code=status.HTTP_204_NO_CONTENT)
def close_worlds(worlds: str, studio: Studio) -> None:
    """Let go of the worlds; a running take is kept as it is, and is in the store by the answer."""
    studio.worlds.close(worlds)


async def _close_when_idle(batch: Batch, studio: Context) -> None:
    while (left := batch.used_at + IDLE_S - time.monotonic()) > 0.0:
        await asyncio.sleep(left)
    with contextlib.suppress(StudioError):  # closed by somebody, or the log tells
        await asyncio.to_thread(studio.worlds.close, batch.name)


def _described(batch: Batch) -> WorldsOut:
    scene, demonstration = batch.scene, batch.demonstration
    chosen = scene.chosen(batch.view)
    return WorldsOut(
        id=batch.name,
        scene=scene.name,
        scene_version=scene.version,
        options=dict(scene.values),
        perception=batch.view.name,
        seeds=list(batch.seeds),
        characters=scene.characters[0] if scene.characters else None,
        dt_s=scene.dt_s,
        outcomes=list(scene.outcomes),
        state=_names(batch.view.state),
        action=_names(scene.action),
        own_action=_names(chosen),
        symbols=list(chosen.names) if isinstance(chosen, Symbols) else [],
        demonstrating=None
        if demonstration is None
        else DemonstratingOut(
            session=demonstration.session.id,
            pilot=demonstration.pilot,
            pairs=demonstration.pairs,
            problem=demonstration.problem,
        ),
        idle_s=IDLE_S,
        socket=f"/api/v1/worlds/{batch.name}/socket",
    )


def _names(space: Space) -> list[str]:
    return ["symbol"] if isinstance(space, Symbols) else list(space.names)


def _told(batch: Batch, seen: Seen, form: Form) -> Response:
    if form == "npz":
        return Response(npz(seen.arrays()), media_type=NPZ)
    outcomes = [batch.scene.outcomes[code] for code in seen.outcomes]
    told = {**seen.arrays(), "outcomes": outcomes, "ended": bool(seen.outcomes.all())}
    return Response(as_json(told), media_type=JSON)
