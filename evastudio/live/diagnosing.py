"""Diagnosing a session: what would keep a policy from learning it, and what to do."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import Progress, silent
from evastudio.learning.delay import Asked
from evastudio.live.perceiving import see_session, unmarked
from evastudio.workspace import Workspace


def diagnose(
    workspace: Workspace,
    session: int | str,
    *,
    perception: str | None = None,
    delay: Asked = "auto",
    progress: Progress = silent,
) -> dict[str, Any]:
    """Look at the pairs that `fit` would learn from. Nothing is written.

    Gives the reaction delay and every finding with its figures, and as `sentences` what there is
    to know and do.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        progress(0.0, "Reading the takes")
        (seen,) = see_session(workspace, store, chosen, [perception])
        marks = store.marks(chosen.id)
    progress(0.4, "Looking at the takes")
    late = seen.delay(delay)
    pairs = seen.pairs(late.steps)
    pairs = pairs.keep(unmarked(pairs, marks))
    if len(pairs) == 0:
        raise InvalidInputError(
            f"Session {chosen.name!r} has no pairs under perception {seen.perception.name!r}. "
            "Choose another perception, or record a take where it applies."
        )
    findings = seen.findings(pairs)
    told = [finding.sentence for finding in findings if finding.found]
    nothing = "Nothing else was found that would keep a policy from learning this."
    progress(1.0, "Looked")
    return {
        "session": chosen.id,
        "perception": seen.perception.name,
        "pairs": len(pairs),
        "sentences": [late.sentence(), *(told or [nothing])],
        "delay": late.report(),
        "findings": [asdict(finding) for finding in findings],
    }
