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
    """Where the lead of `moment` gets when it does each of `actions` (k, m) for a while.

    `colors` (k, 3) is that of each way; the others rest.
    """
    worlds = stack([moment] * len(actions))
    places = [places_of(scene, worlds)]
    for _ in range(max(1, round(AHEAD_S / scene.dt_s))):
        worlds = scene.step(worlds, for_all(scene, worlds, scene.action.clip(actions)))
        places.append(places_of(scene, worlds))
    together = np.stack(places, axis=1)
    return tuple(
        Line(
            f"way {number}",
            way.astype(np.float32),
            np.tile(color, (len(way), 1)),
            pixels=4.0,
        )
        for number, (way, color) in enumerate(zip(together, colors, strict=True))
    )


def _color(familiarity: float | None) -> tuple[int, int, int]:
    if familiarity is None:
        return PLAIN
    low, high = (STRANGE, UNSURE) if familiarity < 0.2 else (UNSURE, FAMILIAR)
    share = familiarity / 0.2 if familiarity < 0.2 else (familiarity - 0.2) / 0.8
    mixed = [round(a + (b - a) * share) for a, b in zip(low, high, strict=True)]
    return mixed[0], mixed[1], mixed[2]
