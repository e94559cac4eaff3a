"""Cleaning a session: its conflicts looked at first, then marked; nothing is deleted."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.records import SessionRecord, Verdict, Verdicts
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.verdicts import judged
from evastudio.learning.cleaning import (
    N_NEIGHBORS,
    THRESHOLD,
    Cleaning,
    Progress,
    clean_pairs,
    silent,
)
from evastudio.learning.delay import Asked
from evastudio.live.conflicts import About, Conflicts
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

    They are looked for among pairs whose reaction delay has been taken out, as in `fit`. What a
    person said of single pairs counts for more.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        verdicts = store.verdicts(chosen.id)
        look = _look(workspace, store, chosen, perception, n_neighbors, threshold, delay, progress)
        marks = judged(look.seen.marks(look.pairs, look.found.conflicts), verdicts)
        report = look.report(verdicts)
        store.save_cleaning(chosen.id, report, marks, clock())
    progress(1.0, "Cleaned")
    removed = sum(int(mask.sum()) for mask in marks.values())
    return {"session": chosen.id, "removed": removed, **report}


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
    """What `clean` would mark, and of the `worst` what they were compared with. Nothing is marked.

    What was found is kept beside the store, for `find_conflicts`.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        verdicts = store.verdicts(chosen.id)
        look = _look(workspace, store, chosen, perception, n_neighbors, "auto", delay, progress)
        identity = store.identity
    progress(0.9, "Comparing the worst")
    conflicts = look.conflicts(identity, chosen.id)
    conflicts.save(workspace)
    limits = conflicts.limits_at(threshold)
    found = replace(
        look.found,
        conflicts=conflicts.marked(threshold),
        limits=limits,
        threshold=threshold,
    )
    report = replace(look, found=found).report(verdicts)
    rows = conflicts.ordered(np.flatnonzero(found.conflicts), threshold)[:worst]
    told = [
        {
            **_moment(conflicts, row),
            "median": median.tolist(),
            "deviation": float(conflicts.deviations[row]),
            "limit": float(limits[row]),
            "neighbors": [_moment(conflicts, other) for other in conflicts.neighbors[row]],
        }
        for row, median in zip(rows, conflicts.medians(rows), strict=True)
    ]
    progress(1.0, "Looked")
    removed = int(conflicts.going(threshold, verdicts).sum())
    return {"session": chosen.id, "removed": removed, **report, "worst": told}


@dataclass(frozen=True)
class _Look:
    """The conflicts of a session, and how they were looked for."""

    seen: Seen
    perception: str
    pairs: Pairs
    found: Cleaning
    asked: Asked
    """The delay."""
    steps: int
    """What it came to."""

    def report(self, verdicts: Verdicts) -> dict[str, Any]:
        """The figures, as JSON holds them; where people judged pairs themselves, how many."""
        said = Counter(verdict is Verdict.DELETE for verdict in verdicts.values())
        return {
            "perception": self.perception,
            "neighbors": self.found.n_neighbors,
            "delay": self.asked,
            "delay_s": self.steps * self.seen.scene.dt_s,
            **self.found.report(),
            **({"kept_by_hand": said[False], "deleted_by_hand": said[True]} if said else {}),
        }

    def conflicts(self, store: str, session: int) -> Conflicts:
        """What was found, for every threshold."""
        chosen = self.seen.scene.chosen(self.seen.perception)
        about = About(
            store=store,
            session=session,
            seen={take.take: len(take) for take in self.seen.takes},
            perception=self.perception,
            n_neighbors=self.found.n_neighbors,
            delay_s=self.steps * self.seen.scene.dt_s,
            delay_steps=self.steps,
            span=tuple(self.found.span.tolist()),
            names=chosen.names,
        )
        return Conflicts.of(about, self.pairs, self.found)


def _look(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    perception: str | None,
    n_neighbors: int,
    threshold: float | str,
    delay: Asked,
    progress: Progress,
) -> _Look:
    progress(0.0, "Reading the takes")
    (seen,) = see_session(workspace, store, session, [perception])
    steps = seen.delay(delay).steps
    pairs = seen.pairs(steps)
    found = clean_pairs(
        pairs,
        seen.scene,
        perception,
        n_neighbors=n_neighbors,
        threshold=threshold,
        progress=lambda share, doing: progress(0.3 + 0.6 * share, doing),
    )
    return _Look(seen, seen.perception.name, pairs, found, delay, steps)


def _moment(conflicts: Conflicts, row: int) -> dict[str, Any]:
    return {
        "take": int(conflicts.takes[row]),
        "step": int(conflicts.steps[row]),
        "action": conflicts.actions[row].tolist(),
    }
