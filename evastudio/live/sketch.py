"""What is drawn over a world: the way a character came, and ways that it could go."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.live.reel import Reel, places_of
from evastudio.live.run import Run
from evastudio.pilots.why import Why
from evastudio.world.bodies import Line
from evastudio.world.cast import for_all
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot, stack
from evastudio.world.spaces import Array

TRAIL_S = 12.0
"""How much of the way it came is shown."""
AHEAD_S = 1.0
"""For how long an action is followed that is shown as a way to go."""
FAMILIAR, UNSURE, STRANGE = (70, 225, 190), (255, 205, 80), (255, 60, 110)
"""Colours, told apart by people who see few."""
HEAD = 0.12
"""Length of the head of an arrow, as a share of the arrow."""
PLAIN = (150, 160, 185)
"""Where no familiarity is known."""
STEERED = (110, 190, 255)
"""Where a person had taken over."""
LED = (255, 240, 200)
"""Of the ways that demonstrated moments lead."""


class Trail:
    """The way the lead came, coloured by how familiar each moment was. Made once for each step."""

    def __init__(self) -> None:
        self._reel: Reel | None = None
        self._until = -1
        self._line: Line | None = None

    def drawn(self, run: Run) -> Line:
        """Up to where `run` stands."""
        if self._line is None or run.reel is not self._reel or run.steps != self._until:
            self._reel, self._until = run.reel, run.steps
            first = max(run.reel.first, run.steps - round(TRAIL_S / run.scene.dt_s))
            places = [run.reel.place(step) for step in range(first, run.steps + 1)]
            known = run.reel.familiarity(first, run.steps)
            colored = [
                STEERED if run.reel.steered(step) else _color(one)
                for step, one in enumerate(known, start=first)
            ]
            colors = np.array([*colored, colored[-1] if colored else PLAIN], dtype=np.uint8)
            self._line = Line("trail", np.array(places, dtype=np.float32), colors)
        return self._line


class Led:
    """Where the moments that a decision came from would lead, each action for a while. The more one
    counted, the brighter it is. Made once for each decision."""

    def __init__(self) -> None:
        self._why: Why | None = None
        self._lines: tuple[Line, ...] = ()

    def drawn(self, run: Run) -> tuple[Line, ...]:
        """Of the decision that `run` stands at."""
        step = min(run.steps, run.reel.last - 1)
        why = run.reel.why(step)
        if why is not self._why:
            self._why, self._lines = why, ()
            if why is not None and why.actions is not None and len(why.actions):
                shares = (0.35 + 0.65 * why.weights / why.weights.max())[:, None]
                colors = np.round(np.array([LED]) * shares).astype(np.uint8)
                self._lines = ways(run.scene, run.reel.moment(step), why.actions, colors)
        return self._lines


def ways(
    scene: Scene, moment: Snapshot, actions: Array, colors: NDArray[np.uint8]
) -> tuple[Line, ...]:
    """Where the lead of `moment` gets when it does each of `actions` (k, m) for a while: arrows.

    `colors` (k, 3) is that of each way; the others rest.
    """
    worlds = stack([moment] * len(actions))
    places = [places_of(scene, worlds)]
    for _ in range(max(1, round(AHEAD_S / scene.dt_s))):
        worlds = scene.step(worlds, for_all(scene, worlds, scene.action.clip(actions)))
        places.append(places_of(scene, worlds))
    together = np.stack(places, axis=1)
    return tuple(
        _arrow(f"way {number}", way, color)
        for number, (way, color) in enumerate(zip(together, colors, strict=True))
    )


def _arrow(name: str, way: Array, color: NDArray[np.uint8]) -> Line:
    points = _pointed(way)
    return Line(name, points, np.tile(color, (len(points), 1)), pixels=4.0)


def _pointed(way: Array) -> NDArray[np.float32]:
    """`way` (n, 3) with the head of an arrow at its end, level with the ground where it is not
    steep; as it is where it leads nowhere."""
    length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    last = way[-1] - way[-2]
    if length < 1e-6 or not last.any():
        return way.astype(np.float32)
    ahead = last / np.linalg.norm(last)
    across = np.cross(ahead, (0.0, 0.0, 1.0))
    if not across.any():
        across = np.array([1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    size = HEAD * length
    barbs = [way[-1] - size * (ahead + side * 0.5 * across) for side in (1.0, -1.0)]
    return np.array([*way, barbs[0], way[-1], barbs[1]], dtype=np.float32)


def _color(familiarity: float | None) -> tuple[int, int, int]:
    if familiarity is None:
        return PLAIN
    low, high = (STRANGE, UNSURE) if familiarity < 0.2 else (UNSURE, FAMILIAR)
    share = familiarity / 0.2 if familiarity < 0.2 else (familiarity - 0.2) / 0.8
    mixed = [round(a + (b - a) * share) for a, b in zip(low, high, strict=True)]
    return mixed[0], mixed[1], mixed[2]
