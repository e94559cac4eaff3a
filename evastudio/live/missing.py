"""Pairs of which people said that something is missing: what a fit says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.demonstrations.records import SessionRecord, Verdict, Verdicts
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import Cleaning, clean_pairs
from evastudio.live.perceiving import Seen, perceptions_alike, see_session
from evastudio.workspace import Workspace
from evastudio.world.spaces import Array

APART = 0.5
"""A perception tells a pair from the others where it deviates this much less from what was done in
moments alike than under the present one."""


def missing_words(
    workspace: Workspace,
    session: SessionRecord,
    seen: Seen,
    delay_steps: int,
    verdicts: Verdicts,
) -> list[str]:
    """What to say where something is missing, and whether another perception at hand has it.

    `seen` is the session under the perception that was fitted.
    """
    moments = [moment for moment, verdict in verdicts.items() if verdict is Verdict.MISSING]
    if not moments:
        return []
    some = "1 moment" if len(moments) == 1 else f"{len(moments)} moments"
    said = f"Of {some} you said that something is missing"
    start = f"{said}: what decided you there may not be in what the character sees."
    others = perceptions_alike(seen.scene, seen.perception.name)[1:]
    if not others:
        return [f"{start} Add it to the scene's perception."]
    with Store(workspace.store_url) as store:
        views = [seen, *see_session(workspace, store, session, others)]
    try:
        found = {view.perception.name: _deviations(view, delay_steps, moments) for view in views}
    except InvalidInputError:  # too few pairs are left to compare
        return [start]
    now = found.pop(seen.perception.name)
    has = int((now < APART * np.max(list(found.values()), axis=0)).sum())
    if 2 * has >= len(moments):
        which = "it" if len(moments) == 1 else f"{has} of them"
        return [
            f"{said}: the perception '{seen.perception.name}', fitted here, tells {which} apart."
        ]
    told = {name: int((after < APART * now).sum()) for name, after in found.items()}
    best = max(told, key=lambda name: told[name])
    if 2 * told[best] < len(moments):
        return [
            f"{start} No other perception at hand tells them apart: add to one what is missing."
        ]
    which = "it" if len(moments) == 1 else f"{told[best]} of them"
    return [f"{start} The perception '{best}' tells {which} apart: fit with that one."]


def _deviations(view: Seen, delay_steps: int, moments: Sequence[tuple[int, int]]) -> Array:
    """How far each of `moments`, take and step, is from what was done in moments alike, (n,)."""
    pairs = view.pairs(delay_steps)
    found = clean_pairs(pairs, view.scene, view.perception).deviations
    rows = [np.flatnonzero((pairs.takes == take) & (pairs.steps == step)) for take, step in moments]
    return np.array([found[row[0]] if len(row) else np.nan for row in rows])


def as_judged(
    found: Cleaning, pairs: Pairs, verdicts: Mapping[tuple[int, int], Verdict]
) -> Cleaning:
    """What was `found` in `pairs` but for those that people judged."""
    conflicts = found.conflicts.copy()
    for (take, step), verdict in verdicts.items():
        conflicts[(pairs.takes == take) & (pairs.steps == step)] = verdict is Verdict.DELETE
    return replace(found, conflicts=conflicts)
