"""A walker on a grid that goes to a mark: the smallest scene whose action is a symbol.

| state of a world | shape | meaning                    |
|------------------|-------|----------------------------|
| goal             | (2,)  | cell of the mark; fixed    |
| cell             | (2,)  | where the walker is        |
| steps            | ()    | decisions so far           |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.scene import Control, Percept, Perception, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box, Field, Symbols

SIZE = 9
MOVES = {"stand": (0, 0), "east": (1, 0), "north": (0, 1), "west": (-1, 0), "south": (0, -1)}
WAYS = np.array(list(MOVES.values()))


class ToGoal(Perception):
    """Where the mark lies, as the walker sees it."""

    name = "to-goal"
    summary = "How far the mark lies to the east and to the north."
    state = Box(
        tuple(Field(name, "cells", -float(SIZE), float(SIZE)) for name in ("east", "north"))
    )

    def perceive(self, snapshot: Snapshot) -> Percept:
        apart = (snapshot["goal"] - snapshot["cell"]).astype(np.float64)
        return Percept(apart, np.zeros((len(apart), 0)))


class Walker(Scene):
    name = "walker"
    title = "A walker on a grid"
    version = 1
    dt_s = 0.5
    render_hz = 30.0
    outcomes = ("running", "arrived", "lost")
    successes = frozenset({"arrived"})
    controls = tuple(
        Control(name, f"go {name}", (), (f"Key{name[0].upper()}",), 0.0) for name in list(MOVES)[1:]
    )
    look = Look((0, 0, 0), 10.0, 100.0, (0.0, 0.0, -1.0))
    action = Symbols(tuple(MOVES))
    perceptions: Mapping[str, Perception] = {"to-goal": ToGoal()}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        return Snapshot(
            {"goal": rng.integers(0, SIZE, (worlds, 2))},
            {
                "cell": rng.integers(0, SIZE, (worlds, 2)),
                "steps": np.zeros(worlds, dtype=np.int64),
            },
        )

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        moves = WAYS[actions[:, 0].astype(np.int64)]
        return snapshot.after(
            cell=np.clip(snapshot["cell"] + moves, 0, SIZE - 1), steps=snapshot["steps"] + 1
        )

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        arrived = (snapshot["cell"] == snapshot["goal"]).all(axis=1) & (snapshot["steps"] > 0)
        return np.where(arrived, 1, np.where(snapshot["steps"] >= 40, 2, 0))

    def progress(self, snapshot: Snapshot) -> Array:
        away = np.abs(snapshot["goal"] - snapshot["cell"]).sum(axis=1)
        return np.asarray(1.0 - away / (2.0 * SIZE))

    def intention(self, snapshot: Snapshot, **traits: float) -> Array:
        """Along the larger of the two ways that are left."""
        east, north = (snapshot["goal"] - snapshot["cell"]).T
        along = np.abs(east) >= np.abs(north)
        code = np.where(along, np.where(east > 0, 1, 3), np.where(north > 0, 2, 4))
        return np.where((east == 0) & (north == 0), 0, code)[:, None].astype(np.float64)

    def meshes(self) -> Mapping[str, Mesh]:
        return {"stone": Mesh(np.eye(3), np.array([[0, 1, 2]]), (200, 200, 200))}

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        places = np.zeros((2, 3))
        places[:, :2] = snapshot["cell"][0], snapshot["goal"][0]
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
        return [Body("stones", "stone", places, upright, np.ones(2))]

    def camera(self, snapshot: Snapshot) -> Camera:
        middle = np.array([SIZE / 2.0, SIZE / 2.0, 0.0])
        return Camera(middle + np.array([0.0, 0.0, 20.0]), middle, np.array([0.0, 1.0, 0.0]))
