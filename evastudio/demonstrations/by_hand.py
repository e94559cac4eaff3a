"""Marking single pairs: what a person leaves out, or keeps though a cleaning marked it."""

from __future__ import annotations

import numpy as np

from evastudio.demonstrations.records import Verdict
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError


def mark_by_hand(store: Store, take: int, step: int, left_out: bool, now: float) -> int:
    """A cleaning that is the one in force but for one pair; its id. Undoing it brings that back.

    Fitting leaves the pair out, or uses it again, and so do the cleanings to come. Raises
    NotFoundError for a take that is not there, InvalidInputError for a step that it has not,
    ConflictError for one in the trash.
    """
    record = store.take(take)
    if record.trashed:
        raise ConflictError(f"Take {record.number} is in the trash; bring it back first.")
    store.judge(take, step, Verdict.DELETE if left_out else Verdict.KEEP)
    session = store.session(record.session)
    marked, masks = store.marks(session.id), {}
    for kept in store.takes(session.id):
        mask = np.zeros(kept.pairs, dtype=bool)
        before = marked.get(kept.id, mask)[: kept.pairs]
        mask[: len(before)] = before
        masks[kept.id] = mask
    masks[take][step] = left_out
    settings = {} if session.cleaning is None else dict(session.cleaning.settings)
    settings["by_hand"] = int(settings.get("by_hand", 0)) + 1
    settings["moment"] = [take, step]
    return store.save_cleaning(session.id, settings, masks, now)
