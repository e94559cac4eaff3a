"""Cleaning a session: its conflicts looked at first, then marked; nothing is deleted."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.learning.cleaning import (
    N_NEIGHBORS,
    THRESHOLD,
    Cleaning,
    Progress,
    clean_pairs,
    explain_cleaning,
    silent,
)
from evastudio.learning.delay import Asked
from evastudio.live.perceiving import Seen, see_session
from evastudio.workspace import Workspace

WORST = 20
"""Conflicts that a preview tells in full."""


def clean(
    workspace: Workspace,
    session: int | str,
    *,
    perception: str | None = None,
    n_neighbors: int = N_NEIGHBORS,
    threshold: float | str = THRESHOLD,
    delay: Asked = "auto",
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Mark the conflicts among the kept pairs of a session; fitting leaves them out.

    They are looked for among pairs whose reaction delay has been taken out, as in `fit`.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        seen, pairs, found, report = _found(
            workspace, store, chosen, perception, n_neighbors, threshold, delay, progress
        )
        store.save_cleaning(chosen.id, report, seen.marks(pairs, found.conflicts), clock())
    progress(1.0, "Cleaned")
    return {"session": chosen.id, "removed": report["conflicts"], **report}


def preview(
    workspace: Workspace,
    session: int | str,
    *,
    perception: str | None = None,
    n_neighbors: int = N_NEIGHBORS,
    threshold: float | str = THRESHOLD,
    delay: Asked = "auto",
    worst: int = WORST,
    progress: Progress = silent,
) -> dict[str, Any]:
    """What `clean` would mark, and of the `worst` what they were compared with. Nothing is kept."""
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        _, pairs, found, report = _found(
            workspace, store, chosen, perception, n_neighbors, threshold, delay, progress
        )
    marked = np.flatnonzero(found.conflicts)
    beyond = (found.deviations - found.limits)[marked]
    first = marked[np.argsort(-beyond, kind="stable")][:worst]
    progress(0.9, "Comparing the worst")
    told = [
        {
            **_moment(pairs, one.pair),
            "action": pairs.actions[one.pair].tolist(),
            "median": np.asarray(one.median, dtype=np.float64).tolist(),
            "deviation": one.deviation,
            "limit": one.limit,
            "neighbors": [
                {**_moment(pairs, int(other)), "action": pairs.actions[other].tolist()}
                for other in one.neighbors
            ],
        }
        for one in (explain_cleaning(found, pairs, first) if len(first) else ())
    ]
    progress(1.0, "Looked")
    return {"session": chosen.id, "removed": report["conflicts"], **report, "worst": told}


def _found(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    perception: str | None,
    n_neighbors: int,
    threshold: float | str,
    delay: Asked,
    progress: Progress,
) -> tuple[Seen, Pairs, Cleaning, dict[str, Any]]:
    """The conflicts of a session, and the report on them."""
    progress(0.0, "Reading the takes")
    (seen,) = see_session(workspace, store, session, [perception])
    scene, late = seen.scene, seen.delay(delay)
    pairs = seen.pairs(late.steps)
    found = clean_pairs(
        pairs,
        scene,
        perception,
        n_neighbors=n_neighbors,
        threshold=threshold,
        progress=lambda share, doing: progress(0.3 + 0.6 * share, doing),
    )
    report = {
        "perception": scene.perception(perception).name,
        "neighbors": n_neighbors,
        "delay": delay,
        "delay_s": late.steps * scene.dt_s,
        **found.report(),
    }
    return seen, pairs, found, report


def _moment(pairs: Pairs, number: int) -> dict[str, int]:
    return {"take": int(pairs.takes[number]), "step": int(pairs.steps[number])}
