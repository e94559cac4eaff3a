"""Where has nobody been? Moments from which a short push leads to what no take shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from evastudio.demonstrations.records import TakeRecord
from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import Progress, silent
from evastudio.live.headless import make_scene
from evastudio.live.perceiving import see_session
from evastudio.live.pushing import Push, Shown, can_go_on, drawn_keys, drawn_steps
from evastudio.workspace import Workspace

PLACES = 8
TAKES = 24
"""Of more takes so many are drawn."""
TRIED = 12
"""Moments of each that are pushed on from."""


@dataclass(frozen=True)
class Place:
    """A moment of a take, and what is held from there on to come where nobody was."""

    take: int
    number: int
    """Of the take in its session."""
    step: int
    keys: tuple[str, ...]
    steps: int
    seconds: float
    """When in the take the push begins."""
    familiarity: float
    """Of where it leads, 0 to 1."""
    distance: float
    """From there to the nearest demonstration, standardised."""


def find_places(
    workspace: Workspace,
    session: int | str,
    *,
    places: int = PLACES,
    seed: int = 0,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Where the kept takes of a session do not come, though a second of other keys would.

    Told are `places`, the farthest from everything shown first, no two of one take while there are
    takes. What would end badly at once is left out. Raises InvalidInputError without pairs.
    """
    with Store(workspace.ready().store_url) as store:
        chosen = store.session(session)
        progress(0.0, "Reading the takes")
        (seen,) = see_session(workspace, store, chosen, [None])
        pairs = seen.pairs()
        if len(pairs) < 2:
            raise InvalidInputError(
                f"Session {chosen.name!r} has no pairs under perception {seen.perception.name!r}. "
                "Record a take first."
            )
        shown = Shown(seen.perception, pairs.states, pairs.takes)
        rng = np.random.default_rng(seed)
        takes = [take for take in store.takes(chosen.id) if take.pairs]
        drawn = rng.permutation(len(takes))[:TAKES].tolist()
        found: list[Place] = []
        for done, number in enumerate(drawn):
            progress(done / len(drawn), f"Looking around take {takes[number].number}")
            found += _around(workspace, store, takes[number], shown, rng)
    progress(1.0, "Looked")
    return {"session": chosen.id, "places": [asdict(one) for one in _apart(found, places)]}


def _around(
    workspace: Workspace, store: Store, take: TakeRecord, shown: Shown, rng: np.random.Generator
) -> Iterator[Place]:
    """Where pushes from moments of `take` lead."""
    record = store.session(take.session)
    scene = make_scene(workspace, record.scene, take.options)
    snapshots = store.load_take(take.id).snapshots
    rows = np.sort(rng.choice(take.pairs, min(TRIED, take.pairs), replace=False))
    steps = drawn_steps(scene, rng)
    pushes = [Push(drawn_keys(scene, rng), steps) for _ in rows]
    for row, push in zip(rows.tolist(), pushes, strict=True):
        there = push.applied(scene, snapshots.take(slice(row, row + 1)))
        if not can_go_on(scene, there)[0] or not scene.perception().applies(there)[0]:
            continue
        (distance,) = shown.distances(there)
        yield Place(
            take=take.id,
            number=take.number,
            step=row,
            keys=push.keys,
            steps=push.steps,
            seconds=row * scene.dt_s,
            familiarity=float(shown.familiarity(distance)),
            distance=float(distance),
        )


def _apart(found: list[Place], count: int) -> list[Place]:
    """The `count` farthest of them, of each take the farthest before a second of any."""
    far = sorted(found, key=lambda place: -place.distance)
    ranks: dict[int, int] = {}
    turns = []
    for place in far:
        turns.append(ranks.get(place.take, 0))
        ranks[place.take] = turns[-1] + 1
    order = sorted(range(len(far)), key=lambda one: (turns[one], one))
    return [far[one] for one in order[:count]]
