"""The coach: while one steers it looks whether the decisions can be learned from."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evastudio.learning.legibility import legibility
from evastudio.live.run import Run
from evastudio.live.status import Advice
from evastudio.world.cast import of_lead
from evastudio.world.scene import Scene
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array, Box, Symbols

EVERY_S = 3.0
"""The coach thinks so often, until it has said something."""
AGAIN_S = 12.0
"""And so often from then on: it is some milliseconds of work each time, for every stage."""
SURE = 2
"""And says what it has thought so many times in a row."""
REMEMBERED_S = 120.0
LEAST_S = 20.0
"""How much one has to steer before it says anything."""
LEAST_SHOWN_S = 40.0
"""And before it says whether decisions show: a flight of 36 s tells too little."""
ANSWER_S = 0.4
"""What is done so long from a moment on is the answer to it."""
HIDDEN = 0.96
"""Of `legibility`: from here on decisions do not show."""
SEEN = 0.93
"""And up to here they do. Of 108 s of scripted flights in the asteroid field: careful 0.89, human
0.75, keys 0.62, and 1.04 where rocks are passed by a hair."""
TOUCHED = 0.05
"""Share of its full deflection from which on a control is being steered."""
STILL = 0.02
"""Who steers in less than this share of moments has not steered."""
FAINT = 0.25
"""Whose strongest tenth of moments stays below this share of the full deflection steers faintly."""


class Decisions(NamedTuple):
    """Decisions of the lead, in order."""

    states: Array
    """(moments, n)"""
    frames: AnyArray
    """(moments, ...), see `Percept.frame`."""
    actions: Array
    """(moments, m)"""
    takes: NDArray[np.int64]
    """(moments,), which of the runs that were seen."""


class Remembered:
    """The latest decisions, in arrays that are made once.

    Kept one by one they would be thousands of objects for each of many stages, and all stages wait
    while garbage is looked for among them.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._held: Decisions | None = None
        self._seen = 0

    def add(self, states: Array, frame: AnyArray, action: Array, take: int) -> None:
        """One more, of which each array has a leading axis of one; the oldest goes for it."""
        one = Decisions(states, frame, action, np.array([take]))
        held = self._held
        if held is None or [(part.shape[1:], part.dtype) for part in one] != [
            (part.shape[1:], part.dtype) for part in held
        ]:
            made = (np.empty((self._most, *part.shape[1:]), part.dtype) for part in one)
            held, self._seen = Decisions(*made), 0
            self._held = held
        for whole, part in zip(held, one, strict=True):
            whole[self._seen % self._most] = part[0]
        self._seen += 1

    def all(self) -> Decisions:
        """All that are held, after at least one was added, as a copy."""
        held = self._held
        assert held is not None
        count = min(self._seen, self._most)
        order = np.arange(self._seen - count, self._seen) % self._most
        return Decisions(
            held.states[order], held.frames[order], held.actions[order], held.takes[order]
        )


def at_once(work: Callable[[], None]) -> None:
    """Do it now."""
    work()


class Coach:
    """Remembers each decision of a person, looks at them together now and then, and seldom
    has something to say."""

    def __init__(
        self, dt_s: float, think: Callable[[Callable[[], None]], object] = at_once
    ) -> None:
        """`think` does some milliseconds of work; elsewhere, where the caller cannot wait."""
        self.advice: Advice | None = None
        """None where it is too early to say."""
        self._dt_s = dt_s
        self._think = think
        self._remembered = Remembered(max(round(REMEMBERED_S / dt_s), 400))
        self._run: Run | None = None
        self._takes = self._seen = 0
        self._due = round(EVERY_S / dt_s)
        self._thought: list[Advice | None] = []

    def anew(self) -> Coach:
        """One that has seen nothing yet."""
        return Coach(self._dt_s, self._think)

    def see(self, run: Run, actions: Array) -> None:
        """The decision that the person is about to make: `actions` of all, for the present."""
        if not run.scene.perception().applies(run.after)[0]:
            return
        self._takes += run is not self._run
        self._run = run
        frame, lead = of_lead(run.after, run.percept().frame), of_lead(run.after, actions)
        self._remembered.add(run.states(), frame, lead, self._takes)
        self._seen += 1
        if self._seen >= self._due:
            every = EVERY_S if self.advice is None else AGAIN_S
            self._due = self._seen + max(round(every / self._dt_s), 1)
            moments, scene = self._remembered.all(), run.scene
            self._think(lambda: self._judge(scene, moments))

    def _judge(self, scene: Scene, moments: Decisions) -> None:
        self._thought = [*self._thought, judged(scene, moments)][-SURE:]
        meant = self._thought[-1]
        if meant is not None and self._thought == [meant] * SURE:
            self.advice = meant


def judged(scene: Scene, moments: Decisions) -> Advice | None:
    """What is to be said of these decisions; None where it is too early, or a close call."""
    states, frames, actions, takes = moments
    dt_s = scene.dt_s
    if len(states) * dt_s < LEAST_S:
        return None
    pushed = _deflections(scene, actions)
    if (pushed > TOUCHED).mean() < STILL:
        return Advice.NOTHING
    if len(states) * dt_s < LEAST_SHOWN_S:
        return None
    view = scene.perception()
    chosen = scene.chosen(view)
    long = 1 if isinstance(chosen, Symbols) else max(round(ANSWER_S / dt_s), 1)
    last = len(states) - long + 1
    whole = np.mean([actions[later : last + later] for later in range(long)], axis=0)
    rows = np.flatnonzero(takes[:last] == takes[long - 1 :])
    before = actions[np.maximum(rows - 1, 0)]
    answers, last_done, done = (
        _comparable(chosen, view.to_own(frames[rows], scene.action.clip(some)))
        for some in (whole[rows], before, actions[rows])
    )
    share = legibility(states[rows], answers, last_done, done, dt_s)
    if share is None or SEEN < share < HIDDEN:
        return None
    if share <= SEEN:
        return Advice.SEEN
    return Advice.FAINT if float(np.quantile(pushed, 0.9)) < FAINT else Advice.HIDDEN


def _comparable(chosen: Box | Symbols, own: Array) -> Array:
    """Actions (rows, m) in units in which their components compare; symbols as one of many."""
    if isinstance(chosen, Symbols):
        return np.asarray(np.eye(len(chosen.names))[own[:, 0].astype(int)])
    half = (chosen.high - chosen.low) / 2
    return np.asarray(own / np.where(np.isfinite(half) & (half > 0), half, 1.0))


def _deflections(scene: Scene, actions: Array) -> Array:
    """How far the control that is steered most is steered, in shares of where its keys lead."""
    space = scene.action
    if isinstance(space, Symbols):
        return np.asarray(actions[:, 0] != 0.0, dtype=float)
    furthest = np.zeros(len(actions))
    for control in scene.controls:
        column = space.names.index(control.field)
        value = actions[:, column]
        bound = np.where(value > 0, space.high[column], -space.low[column]) * control.reach
        furthest = np.maximum(furthest, np.abs(value) / np.maximum(bound, 1e-9))
    return furthest
