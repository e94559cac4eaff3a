"""Suspicion: what about a take makes one look at it again before anything is learned from it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np

from evastudio.demonstrations.records import TakeData, TakeRecord
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.spaces import Box

SHORT_S = 2.0
EARLY_S = 5.0
NEARLY_ALL = 0.97
"""Of the moments of a take."""
AT_REST = 0.01
"""Of the full deflection."""
FEW = 5
"""Takes that others can be unlike."""
FAR = 5.0
"""So many times the usual distance from the middle take is unlike the others, as a factor."""
FACTOR = 2.0
"""And so many times as much, or as little."""
LEAST = 1e-3
"""Deflections below it are all alike."""


@dataclass(frozen=True)
class Figures:
    """How a take was steered."""

    rest: float
    """Share of the moments in which nothing was done."""
    held: float
    """Share of the moments in which one thing was done as far as it goes."""
    effort: float
    """How far it was steered, root mean square, of the full deflection."""
    haste: float
    """How much that changed from moment to moment, mean, of the full deflection."""


@dataclass(frozen=True)
class Remark:
    """What is suspicious about a take."""

    kind: str
    """'short', 'still', 'held', 'early' or 'unlike'."""
    says: str


def figures_of(scene: Scene, data: TakeData) -> Figures:
    """Of a take of `scene`."""
    actions = np.asarray(of_lead(data.snapshots, data.actions), dtype=np.float64)
    space = scene.action
    if not isinstance(space, Box):
        return Figures(float((actions[:, 0] == 0.0).mean()), 0.0, 0.0, 0.0)
    steered = [
        space.names.index(control.field)
        for control in scene.controls
        if control.field in space.names
    ] or list(range(space.size))
    low, high = space.low[steered], space.high[steered]
    full = np.where(actions[:, steered] < 0.0, np.abs(low), np.abs(high))
    share = actions[:, steered] / np.where(np.isfinite(full) & (full > 0.0), full, 1.0)
    ends = [(share * way >= 1.0 - AT_REST).mean(axis=0).max() for way in (1.0, -1.0)]
    symbols = not isinstance(scene.chosen(scene.perception()), Box)
    return Figures(
        rest=float((np.abs(share) < AT_REST).all(axis=1).mean()),
        held=0.0 if symbols else float(max(ends)),
        effort=float(np.sqrt((share**2).mean())),
        haste=float(np.abs(np.diff(share, axis=0)).mean()) if len(share) > 1 else 0.0,
    )


def suspicions(
    successes: Set[str], takes: Sequence[TakeRecord], figures: Mapping[int, Figures]
) -> dict[int, list[Remark]]:
    """What is suspicious about each of `takes`, which are one session's; those it is about alone.

    `successes` are the outcomes that end a world well.

    `figures` are those of the takes that have pairs, by their ids. A take that is still recorded
    is not judged.
    """
    kept = [
        figures[take.id]
        for take in takes
        if take.id in figures and not take.trashed and take.seconds >= SHORT_S
    ]
    effort, haste = _usual(one.effort for one in kept), _usual(one.haste for one in kept)
    found = {}
    for take in takes:
        if take.id not in figures:
            continue
        one = figures[take.id]
        remarks = _alone(successes, take, one)
        if not remarks:
            remarks = [
                Remark("unlike", f"Unlike your other takes: {words}.")
                for words in (
                    _compared(one.effort, effort, "steered much more", "steered much less"),
                    _compared(one.haste, haste, "much more abrupt", "much more gentle"),
                )
                if words is not None
            ][:1]
        if remarks:
            found[take.id] = remarks
    return found


def _alone(successes: Set[str], take: TakeRecord, one: Figures) -> list[Remark]:
    """What is suspicious whatever the other takes are."""
    remarks = []
    bad = take.outcome is not None and take.outcome not in successes
    if take.seconds < SHORT_S:
        remarks.append(Remark("short", f"Only {take.seconds:.1f} s long: hardly to learn from."))
    elif bad and take.seconds < EARLY_S:
        remarks.append(Remark("early", f"It went wrong after {take.seconds:.1f} s already."))
    if one.rest >= NEARLY_ALL:
        remarks.append(Remark("still", "Nothing was steered."))
    elif one.held >= NEARLY_ALL:
        remarks.append(Remark("held", "A key was held all the time."))
    return remarks


def _usual(values: Iterable[float]) -> tuple[float, float] | None:
    """The middle one's logarithm and how far others are from it, usually; None for too few."""
    logs = np.log(np.fromiter(values, dtype=np.float64) + LEAST)
    if len(logs) < FEW:
        return None
    middle = float(np.median(logs))
    return middle, float(1.4826 * np.median(np.abs(logs - middle)))


def _compared(value: float, usual: tuple[float, float] | None, more: str, less: str) -> str | None:
    if usual is None:
        return None
    middle, spread = usual
    apart = float(np.log(value + LEAST)) - middle
    if abs(apart) <= max(FAR * spread, np.log(FACTOR)):
        return None
    return more if apart > 0.0 else less
