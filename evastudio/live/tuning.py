"""Tuning a session: what to fit it with, and how well that does on takes it has not seen."""

from __future__ import annotations

from typing import Any

from evastudio.demonstrations.records import SessionRecord
from evastudio.demonstrations.store import Store
from evastudio.evaluation.cluster import on_cluster
from evastudio.learning.cleaning import N_NEIGHBORS, Progress, silent
from evastudio.learning.delay import Asked
from evastudio.learning.tuning import AUTO, JOBS
from evastudio.learning.tuning import tune as tune_pairs
from evastudio.learning.tuning_report import Tuning
from evastudio.live.perceiving import perceptions_alike, see_session
from evastudio.workspace import Workspace
from evastudio.world.loading import find_scene


def tune(
    workspace: Workspace,
    session: int | str,
    *,
    learner: str = AUTO,
    perception: str | None = None,
    cluster: str | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Try learners and settings on the kept takes of a session, each held out whole in turn.

    Nothing is written; `fit` with the learner `auto` does the same and fits what was chosen. The
    trials run here, or on the Dask cluster at the address `cluster`; the report is the same.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
    with on_cluster(cluster) as everywhere:
        report = tune_session(
            workspace,
            chosen,
            learner=learner,
            perception=perception,
            jobs=JOBS if cluster is None else everywhere,
            progress=progress,
        )
    return {"session": chosen.id, **report.to_json()}


def tune_session(
    workspace: Workspace,
    session: SessionRecord,
    *,
    learner: str = AUTO,
    perception: str | None = None,
    delay: Asked = "auto",
    jobs: int = JOBS,
    progress: Progress = silent,
) -> Tuning:
    """The report on a session, the reaction delay taken out as in `fit`.

    Where the session has been cleaned, all is tried cleaned by the same threshold and neighbours.
    """
    progress(0.0, "Reading the takes")
    place = find_scene(session.scene, workspace.scene_folders)()
    names = perceptions_alike(place, perception)
    with Store(workspace.store_url) as store:
        seen = see_session(workspace, store, session, names)
    steps = seen[0].delay(delay).steps
    views = [each.perceived(steps) for each in seen]
    cleaned = {} if session.cleaning is None else session.cleaning.settings
    return tune_pairs(
        views[0].pairs,
        seen[0].scene,
        learner,
        perception=names[0],
        threshold=cleaned.get("threshold"),
        n_neighbors=cleaned.get("neighbors", N_NEIGHBORS),
        views=views,
        n_jobs=jobs,
        progress=progress,
    )
