"""Recorded people as worlds of the street: one of them, or all, gone on by something else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.pairs import Pairs, join_pairs, perceive_take
from evastudio.demonstrations.retracing import (
    Retraced,
    Stepped,
    at_step,
    elsewhere,
    retrace,
    trodden,
)
from evastudio.demonstrations.walks import read_walks
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Perception, Scene
from evastudio.world.snapshot import AnyArray, Snapshot, stack
from evastudio.world.spaces import Array

AHEAD = 12
"""Steps of a forecast, 4.8 s."""
EVERY = 24
"""Steps from the beginning of one forecast to the next."""
TOUCH_M = 0.3
"""Nearer than this two people touch."""
LATE = 1.5
"""Who needs longer than so many times the person's own time has not arrived."""
CROWD = 30
"""Characters of a world in which one is led."""
ROOT = Path(__file__).resolve().parents[2]
STREET = load_scene_file(ROOT / "scenes" / "street.py")

Decide = Callable[[Scene, Snapshot], Array]
"""Actions (worlds, N, m) for all characters."""


@dataclass(frozen=True)
class Led:
    """People of one recording whose ways are taken, each in a world of its own."""

    retraced: tuple[Retraced, ...]
    moments: tuple[tuple[Snapshot, ...], ...]
    """Of each world, until the person has arrived."""

    def pairs(self, view: Perception, known: int = 0) -> Pairs:
        """What these people saw and did; takes are numbered from `known` on."""
        return join_pairs(
            [
                perceive_take(view, stack(moments), one.actions[: len(moments)], known + take)
                for take, (one, moments) in enumerate(zip(self.retraced, self.moments, strict=True))
            ]
        )


def recording(path: Path, fps: float | None) -> Stepped:
    """A file at the street's step."""
    return at_step(read_walks(path, fps), STREET.dt_s)


def led(stepped: Stepped, people: int) -> Led:
    """So many of those who go somewhere, evenly spread; worlds go on after they have arrived."""
    leads = stepped.travellers()
    if people < len(leads):
        leads = leads[np.linspace(0, len(leads) - 1, people).round().astype(np.int64)]
    ways, worlds, walked = trodden(stepped), [], []
    for lead in leads.tolist():
        begins = int(stepped.first[lead])
        taken = len(stepped.places[lead])
        ends = begins + taken + int(np.ceil((LATE - 1.0) * taken))
        who = np.array([lead, *stepped.beside(lead, begins, begins + taken, CROWD - 1)])
        world = retrace(STREET, stepped, who, begins, ends, elsewhere(ways, lead))
        worlds.append(world)
        walked.append(tuple(moment for moment, _ in world.moments()))
    return Led(tuple(worlds), tuple(walked))


def padded(snapshot: Snapshot, people: int, shape: tuple[int, int]) -> Snapshot:
    """The same worlds with characters who never come, and more ground that nobody walks on."""

    def wide(name: str, array: AnyArray) -> AnyArray:
        if name == "ground":
            short = [size - now for size, now in zip(shape, array.shape[1:], strict=True)]
            return np.pad(array, [(0, 0), *((0, more) for more in short)])
        if array.ndim < 2 or name == "corner":
            return array
        more = people - array.shape[1]
        rest = [(0, 0)] * (array.ndim - 2)
        fill = 1 if name == "size" else 0
        return np.pad(array, [(0, 0), (0, more), *rest], constant_values=fill)

    return Snapshot(
        {name: wide(name, array) for name, array in snapshot.fixed.items()},
        {name: wide(name, array) for name, array in snapshot.moving.items()},
    )


@dataclass(frozen=True)
class Rolled:
    """What became of leads whose others went as recorded."""

    forecast: Array
    """Metres off after each of AHEAD steps, shape (forecasts, AHEAD)."""
    whole: Array
    """Mean metres off over a person's whole way, shape (people,)."""
    touched: Array
    """Times that each came to touch somebody, shape (people,)."""
    arrived: NDArray[np.bool_]
    """Who reached the goal within LATE of the person's time, shape (people,)."""
    off_ground: float
    """Share of the steps farther than half a metre from where anybody else walked."""


def roll(leads: Led, decide: Decide | None) -> Rolled:
    """Leads go on as `decide` says, or as they were recorded where it is None; others as recorded.

    Forecasts begin every EVERY steps of a way, whole ways at its beginning.
    """
    starts, of, skip = [], [], []
    for number, moments in enumerate(leads.moments):
        for at in range(0, max(len(moments) - AHEAD, 1), EVERY):
            starts.append(moments[at])
            of.append(number)
            skip.append(at)
    high = max(one["ground"].shape[1] for one in starts)
    wide = max(one["ground"].shape[2] for one in starts)
    moment = stack([padded(one, CROWD, (high, wide)) for one in starts])
    scene = STREET(people=float(CROWD), length=3600.0)
    longest = [len(one.actions) for one in leads.retraced]
    steps = max(longest)
    theirs = np.zeros((len(starts), steps, CROWD, scene.action.size))
    true = np.full((len(starts), steps + 1, 2), np.nan)
    for row, (number, at) in enumerate(zip(of, skip, strict=True)):
        actions = leads.retraced[number].actions[at:]
        theirs[row, : len(actions), : actions.shape[1]] = actions
        way = [one["position"][0, 0] for one in leads.moments[number][at:]]
        true[row, : len(way)] = way
    index = np.arange(len(starts))
    begins = np.array(skip) == 0
    off = np.full((len(starts), steps + 1), np.nan)
    touching = np.zeros(len(starts), dtype=bool)
    touched = np.zeros(len(starts))
    arrived = np.zeros(len(starts), dtype=bool)
    strayed, walked = 0, 0
    allowed = np.array([int(LATE * len(leads.moments[number])) for number in of])
    for step in range(steps):
        actions = theirs[:, step]
        if decide is not None:
            actions = actions.copy()
            actions[:, 0] = decide(scene, moment)[:, 0]
        moment = scene.step(moment, actions)
        place = moment["position"][:, 0]
        off[:, step + 1] = np.hypot(*(place - true[:, step + 1]).T)
        arrived |= (moment["leg"][:, 0] > 0) & (step < allowed)
        active = moment["present"][:, 0] > 0
        active &= (moment["leg"][:, 0] == 0) & (step < allowed)
        apart = moment["position"][:, 1:] - place[:, None]
        far = np.where(moment["present"][:, 1:] > 0, np.hypot(apart[..., 0], apart[..., 1]), np.inf)
        now = (far.min(axis=1) < TOUCH_M) & active
        touched += now & ~touching
        touching = now
        cells = np.floor((place - moment["corner"]) / 0.2).astype(np.int64)
        near = np.zeros(len(starts), dtype=bool)
        for dx in (-2, 0, 2):
            for dy in (-2, 0, 2):
                x, y = cells[:, 0] + dx, cells[:, 1] + dy
                ok = (x >= 0) & (x < wide) & (y >= 0) & (y < high)
                near |= ok & (moment["ground"][index, y.clip(0, high - 1), x.clip(0, wide - 1)] > 0)
        strayed += int((active & ~near & begins).sum())
        walked += int((active & begins).sum())
    forecast = off[:, 1 : AHEAD + 1]
    return Rolled(
        forecast[~np.isnan(forecast).any(axis=1)],
        np.nanmean(off[begins, 1:], axis=1),
        touched[begins],
        arrived[begins],
        strayed / max(walked, 1),
    )


@dataclass(frozen=True)
class Crowded:
    """A whole recording in which everybody goes on by the same."""

    touches: float
    """Times a minute that somebody comes to touch somebody."""
    speeds: Array
    """Metres a second, of all at all steps."""
    arrived: float
    """Share of those who came that left at their goals."""


def crowd(stepped: Stepped, decide: Decide | None, most: int) -> Crowded:
    """The first `most` steps of a recording; people come as recorded and leave at their goals."""
    people = np.flatnonzero(stepped.first < most - 2)
    stop = max(int(stepped.first[people].max()) + 2, most)
    world = retrace(STREET, stepped, people, 0, stop, np.concatenate(trodden(stepped)))
    moment, scene = world.start, world.scene
    if decide is not None:
        fixed = {**moment.fixed, "leaves": np.zeros_like(moment["leaves"])}
        moment = Snapshot(fixed, moment.moving)
    touching = np.zeros((len(people), len(people)), dtype=bool)
    touches, seen_s, speeds = 0, 0.0, []
    came = np.zeros(len(people), dtype=bool)
    for actions in world.actions[:most]:
        chosen = actions[None] if decide is None else decide(scene, moment)
        moment = scene.step(moment, chosen)
        here = moment["present"][0] > 0
        came |= here
        apart = moment["position"][0, :, None] - moment["position"][0, None]
        near = (np.hypot(apart[..., 0], apart[..., 1]) < TOUCH_M) & here[:, None] & here[None]
        np.fill_diagonal(near, False)
        touches += int((near & ~touching).sum())
        touching = near
        seen_s += float(here.sum()) * scene.dt_s
        speeds.append(np.hypot(*moment["velocity"][0, here].T))
    gone = came & ~(moment["present"][0] > 0)
    return Crowded(60.0 * touches / seen_s, np.concatenate(speeds), float(gone.sum() / came.sum()))


def joined(parts: Sequence[Led], view: Perception) -> Pairs:
    """The pairs of several recordings, takes numbered through."""
    pairs, known = [], 0
    for part in parts:
        pairs.append(part.pairs(view, known))
        known += len(part.moments)
    return join_pairs(pairs)


def mirrored(pairs: Pairs, signs: Array) -> Pairs:
    """`pairs` and what they would be in a mirror; `signs` of the state's components."""
    turned = replace(
        pairs, states=pairs.states * signs, actions=pairs.actions * np.array([1.0, -1.0])
    )
    return join_pairs([pairs, turned])
