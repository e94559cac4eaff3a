"""Routes: the pairs of a session, as learners see them."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from fastapi import APIRouter, Query, Request, Response

from evastudio.api.arrays import CSV, JSON, NPZ, as_csv, as_json, npz
from evastudio.api.context import Studio
from evastudio.api.downloads import BINARY, TEXT, download, downloadable, etag_of
from evastudio.api.models.common import Name
from evastudio.errors import InvalidInputError
from evastudio.live.headless import make_scene
from evastudio.live.perceiving import see_session, unmarked
from evastudio.world.spaces import Symbols

router = APIRouter(tags=["sessions"])

MOST_AS_TEXT = 20_000
"""Pairs that can be had as JSON or CSV; more come as npz."""
Form = Annotated[Literal["json", "npz", "csv"], Query(alias="format")]


@router.get(
    "/sessions/{session}/pairs",
    response_class=Response,
    responses=downloadable(
        {JSON: {"schema": {"$ref": "#/components/schemas/PairsOut"}}, NPZ: BINARY, CSV: TEXT}
    ),
)
def get_pairs(
    session: int,
    request: Request,
    studio: Studio,
    form: Form = "json",
    perception: Annotated[Name | None, Query()] = None,
) -> Response:
    """The pairs of the kept takes under a perception, actions in the character's own frame.

    With each its take, its step, whether cleaning marked it as a conflict, and whether it corrects
    a policy. As npz: `states`, `actions`, `takes`, `steps`, `conflicts`, `corrections`.
    """
    record = studio.store.session(session)
    scene = make_scene(studio.workspace, record.scene)
    view = scene.perception(perception)
    if form != "npz" and record.pairs > MOST_AS_TEXT:
        raise InvalidInputError(
            f"Session {record.name!r} has {record.pairs} pairs; as {form} there are at most "
            f"{MOST_AS_TEXT}. Ask for format=npz."
        )
    kept = studio.store.takes(session)
    takes = [(take.id, take.pairs) for take in kept]
    correcting = [take.id for take in kept if take.origin is not None and take.origin.policy]
    cleaning = None if record.cleaning is None else record.cleaning.id
    store = studio.store.identity
    etag = etag_of("pairs", store, session, takes, cleaning, scene.version, view.name, form)

    def content() -> bytes:
        (seen,) = see_session(studio.workspace, studio.store, record, [view.name])
        pairs = seen.pairs()
        conflicts = ~unmarked(pairs, studio.store.marks(session))
        chosen = scene.chosen(view)
        names = ["symbol"] if isinstance(chosen, Symbols) else list(chosen.names)
        arrays = {
            "states": pairs.states,
            "actions": pairs.actions,
            "takes": pairs.takes,
            "steps": pairs.steps,
            "conflicts": conflicts,
            "corrections": np.isin(pairs.takes, correcting),
        }
        if form == "npz":
            return npz(arrays)
        if form == "json":
            return as_json({"state": list(view.state.names), "action": names, **arrays})
        columns = ["take", "step", "conflict", "correction", *view.state.names, *names]
        flags = [arrays[name].astype(np.int64) for name in ("conflicts", "corrections")]
        return as_csv(columns, pairs.takes, pairs.steps, *flags, pairs.states, pairs.actions)

    kind = {"json": JSON, "npz": NPZ, "csv": CSV}[form]
    return download(request, etag, f"session-{session}.{form}", kind, content)
