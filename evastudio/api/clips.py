"""Routes: the clips of the workspace, and which of them is played for which activity."""

from __future__ import annotations

import asyncio

from fastapi import APIRouter, Request

from evastudio.api.context import Context, Studio
from evastudio.api.models.clips import ClipIn, ClipsOut
from evastudio.errors import InvalidInputError
from evastudio.live.clips import add_clips, choose_clip, clips, dress, forget_clip
from evastudio.motion.library import MOST_BYTES

router = APIRouter(prefix="/clips", tags=["clips"])


@router.get("")
def get_clips(studio: Studio) -> ClipsOut:
    """The files of clips, and what is chosen for each activity."""
    return ClipsOut.model_validate(clips(studio.workspace))


@router.put("/files/{name}", max_body_size=MOST_BYTES)
async def put_file(name: str, request: Request, studio: Studio) -> ClipsOut:
    """Keep the body as a file of that name, .glb or .bvh; nothing is kept that cannot be read."""
    data = bytearray()
    async for chunk in request.stream():
        data += chunk
        if len(data) > MOST_BYTES:
            raise InvalidInputError(
                f"{name[:120]!r} is larger than {MOST_BYTES // 1_000_000} MB; export fewer clips."
            )
    told = await asyncio.to_thread(add_clips, studio.workspace, name, bytes(data))
    await asyncio.to_thread(_dress_all, studio)
    return ClipsOut.model_validate(told)


@router.put("/activities/{activity}")
def choose(activity: str, body: ClipIn, studio: Studio) -> ClipsOut:
    """Play a clip for an activity; whoever is watched moves so at once."""
    told = choose_clip(studio.workspace, activity, body.file, body.clip)
    _dress_all(studio)
    return ClipsOut.model_validate(told)


@router.delete("/activities/{activity}")
def forget(activity: str, studio: Studio) -> ClipsOut:
    """Move as shipped in that activity."""
    told = forget_clip(studio.workspace, activity)
    _dress_all(studio)
    return ClipsOut.model_validate(told)


def _dress_all(studio: Context) -> None:
    for stage in studio.stages.all():
        dress(stage.scene, studio.workspace)
