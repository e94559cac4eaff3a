"""Studies of people in a workspace: listed, and forgotten as the person wishes."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.evaluation.studies import forget_study, study_records
from evastudio.workspace import Workspace


def studies(workspace: Workspace, *, forget: int | None = None) -> list[dict[str, Any]]:
    """The studies kept, oldest first; without the one of id `forget`, which is deleted for good.

    Raises NotFoundError where there is no such study.
    """
    with Store(workspace.ready().store_url) as store:
        if forget is not None:
            forget_study(store, forget)
        return [asdict(record) for record in study_records(store)]
