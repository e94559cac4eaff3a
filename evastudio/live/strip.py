"""A strip: what there is to see in a run, along its time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from evastudio.live.reel import Reel
from evastudio.world.cast import of_lead
from evastudio.world.snapshot import Snapshot

PLACES = 240
"""Places along a strip that have a familiarity of their own."""
MOST_LOOKED_AT = 1200
"""Of a longer run not every moment is looked at for what happened."""


@dataclass(frozen=True)
class Happening:
    """Something that happened at one moment of a run."""

    seconds: float
    kind: str
    """'sign', 'near', 'hand' or 'outcome'."""
    says: str
    """What a person reads; of an outcome its name."""


@dataclass(frozen=True)
class Strip:
    """A run, along its time. Seconds count from its beginning."""

    first_s: float
    """What was before is forgotten."""
    length_s: float
    familiarity: list[float | None]
    """Of each part of the time from `first_s` on, all as long, the least there was."""
    happenings: list[Happening]


def strip_of(reel: Reel, moments: Sequence[Snapshot]) -> Strip:
    """Of `reel`, whose `moments` these are; the reel may go on meanwhile."""
    dt_s, first = reel.scene.dt_s, reel.first
    last = first + len(moments) - 1
    known = reel.familiarity(first, last)
    edges = np.linspace(0, len(known), min(PLACES, len(known)) + 1).astype(int)
    parts = [known[low:high] for low, high in pairwise(edges)]
    return Strip(
        first_s=first * dt_s,
        length_s=last * dt_s,
        familiarity=[min((one for one in part if one is not None), default=None) for part in parts],
        happenings=[
            Happening((first + at) * dt_s, kind, says)
            for at, kind, says in _happened(reel, moments)
        ],
    )


def _happened(reel: Reel, moments: Sequence[Snapshot]) -> list[tuple[int, str, str]]:
    """Where in `moments` what begins: signs of the scene, close calls, the end."""
    scene = reel.scene
    stride = max(1, -(-len(moments) // MOST_LOOKED_AT))
    looked_at = range(0, len(moments), stride)
    events = [index for index, sign in enumerate(scene.signs) if sign.unit is None]
    found = _steered(reel, len(moments))
    before, was_near = np.zeros(len(scene.signs)), False
    for at in looked_at:
        moment = moments[at]
        now = of_lead(moment, scene.notice(moment))[0]
        found += [
            (at, "sign", scene.signs[index].label)
            for index in events
            if now[index] and not before[index]
        ]
        near = bool(scene.clearance(moment)[0] < scene.near_m)
        if near and not was_near:
            found.append((at, "near", "a close call"))
        before, was_near = now, near
    outcome = int(scene.outcome(moments[-1])[0])
    if outcome:
        found.append((len(moments) - 1, "outcome", scene.outcomes[outcome]))
    return found


def _steered(reel: Reel, moments: int) -> list[tuple[int, str, str]]:
    """Where a person took over, and where they handed back."""
    by_hand = [reel.steered(reel.first + at) for at in range(moments - 1)]
    return [
        (at, "hand", "you took over" if now else "you handed back")
        for at, (before, now) in enumerate(pairwise([False, *by_hand]))
        if now is not before
    ]
