"""What would go if a session were cleaned now, and why: for people who decide about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evastudio.demonstrations.records import SessionRecord, TakeRecord, Verdict, Verdicts
from evastudio.demonstrations.store import Store
from evastudio.live.conflicts import Conflicts, Mask, find_conflicts
from evastudio.workspace import Workspace
from evastudio.world.spaces import Array

NOTHING = 0.05
"""An action this short, as a share of the range, is as good as none."""
MORE = 1.5
"""So many times as far is much more."""


@dataclass(frozen=True)
class Weighed:
    """A pair that conflicts with others, or that somebody decided about."""

    take: int
    number: int
    """Of the take in its session, from 1."""
    step: int
    seconds: float
    """When in its take, of the moment that the action answered."""
    says: str
    """What is odd about it, for its demonstrator."""
    action: Mapping[str, float]
    """In the character's own frame, by name; a symbol as {its name: 1}."""
    usual: Mapping[str, float]
    """The median of what was done in moments like it, likewise."""
    deviation: float
    """See `Conflict`."""
    limit: float
    conflict: bool
    """Whether it is farther off than the limit."""
    verdict: Verdict | None
    goes: bool
    """Whether cleaning would leave it out."""


@dataclass(frozen=True)
class Weighing:
    """What would go, and the conflicts that are farthest off."""

    pairs: int
    """That were looked at and are kept still."""
    conflicts: int
    goes: int
    """Pairs that cleaning would leave out, what was decided about single ones included."""
    limit: float
    """The middle of the limits: where a slider stands that no one has moved."""
    perception: str
    """What was compared is what this one shows."""
    neighbors: int
    """Moments that each pair is compared with."""
    symbols: bool
    """Whether actions are symbols."""
    stale: bool
    """Takes were added, thrown away or brought back since: look again."""
    items: tuple[Weighed, ...]
    """The farthest off first."""


def weigh(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    threshold: float | str = "auto",
    most: int = 50,
) -> Weighing:
    """What would go at that threshold, `most` of it in full.

    Everything about distances was worked out when somebody looked, so that this takes a moment.
    Raises NotFoundError where nobody has looked, InvalidInputError for a threshold that is none.
    """
    found = find_conflicts(workspace, store.identity, session)
    takes = {take.id: take for take in store.takes(session.id) if take.pairs}
    verdicts = store.verdicts(session.id)
    limits = found.limits_at(threshold)
    kept = found.among(list(takes))
    marked, going = found.marked(threshold) & kept, found.going(threshold, verdicts) & kept
    listed = marked.copy()
    listed[found.rows(verdicts)] = True
    rows = found.ordered(np.flatnonzero(listed & kept), threshold)[:most]
    return Weighing(
        pairs=int(kept.sum()),
        conflicts=int(marked.sum()),
        goes=int(going.sum()),
        limit=float(np.median(limits)),
        perception=found.about.perception,
        neighbors=found.about.n_neighbors,
        symbols=not found.about.span,
        stale={number: take.pairs for number, take in takes.items()} != found.about.seen,
        items=tuple(
            _weighed(found, int(row), takes, median, limits, verdicts, going)
            for row, median in zip(rows, found.medians(rows), strict=True)
        ),
    )


@dataclass(frozen=True)
class Neighbor:
    """A pair that another was compared with."""

    take: int
    step: int
    action: Mapping[str, float]
    """As in `Weighed`."""


@dataclass(frozen=True)
class Compared:
    """A pair beside those that it was compared with."""

    conflict: Weighed
    neighbors: tuple[Neighbor, ...]
    """The nearest first."""


def compared(
    workspace: Workspace,
    store: Store,
    session: SessionRecord,
    take: int,
    step: int,
    threshold: float | str = "auto",
) -> Compared:
    """One pair, a conflict or not, and its neighbours. Raises as `weigh`, and NotFoundError for a
    pair that was not looked at."""
    found = find_conflicts(workspace, store.identity, session)
    row, verdicts = found.row(take, step), store.verdicts(session.id)
    record = store.take(take)
    limits, going = found.limits_at(threshold), found.going(threshold, verdicts)
    median = found.medians(np.array([row]))[0]
    return Compared(
        _weighed(found, row, {take: record}, median, limits, verdicts, going),
        tuple(
            Neighbor(
                int(found.takes[other]),
                int(found.steps[other]),
                _named(found, found.actions[other]),
            )
            for other in found.neighbors[row]
        ),
    )


def _weighed(
    found: Conflicts,
    row: int,
    takes: Mapping[int, TakeRecord],
    median: Array,
    limits: Array,
    verdicts: Verdicts,
    going: Mask,
) -> Weighed:
    number, step = int(found.takes[row]), int(found.steps[row])
    take, deviation, limit = takes[number], float(found.deviations[row]), float(limits[row])
    dt_s = take.seconds / take.pairs
    return Weighed(
        take=take.id,
        number=take.number,
        step=step,
        seconds=round((step - found.about.delay_steps) * dt_s, 6),
        says=_words(found, row, median),
        action=_named(found, found.actions[row]),
        usual=_named(found, median),
        deviation=deviation,
        limit=limit,
        conflict=deviation > limit,
        verdict=verdicts.get((number, step)),
        goes=bool(going[row]),
    )


def _named(found: Conflicts, action: Array) -> dict[str, float]:
    names = found.about.names
    if not found.about.span:
        return {names[int(action[0])]: 1.0}
    return dict(zip(names, action.tolist(), strict=True))


def _words(found: Conflicts, row: int, median: Array) -> str:
    """What is odd about a pair, without naming components: people steer, they do not see those."""
    about = found.about
    if not about.span:
        chosen, usual = (about.names[int(one[0])] for one in (found.actions[row], median))
        alike = int((found.actions[found.neighbors[row], 0] == median[0]).sum())
        share = f"in {alike} of {about.n_neighbors} moments like this"
        return f"You chose \u2018{chosen}\u2019; {share} it was \u2018{usual}\u2019."
    own, other = found.actions[row] / about.span, median / about.span
    length, usual_length = float(np.linalg.norm(own)), float(np.linalg.norm(other))
    if length <= NOTHING < usual_length:
        return "You did nothing; in moments like this you usually did something."
    if usual_length <= NOTHING < length:
        return "You did something; in moments like this you usually did nothing."
    if float(own @ other) < 0.0:
        return "You did the opposite of what you usually did in moments like this."
    if length > MORE * usual_length:
        return "You did much more than you usually did in moments like this."
    if usual_length > MORE * length:
        return "You did much less than you usually did in moments like this."
    return "You did something else than you usually did in moments like this."
