"""An organ: every key of the keyboard is a part of the action of its own, without a ramp.

What was recorded of a key is so how much of each step it was held, and nothing else. It has no end,
and hardly anything to draw.

| state of a world | shape | meaning                          |
|------------------|-------|----------------------------------|
| steps            | ()    | decisions so far                 |
"""

from __future__ import annotations

import string
from collections.abc import Mapping, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from evastudio.world.bodies import Body, Camera, Look, Mesh
from evastudio.world.scene import Control, Percept, Perception, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box, Field

CODES = (
    *(f"Key{letter}" for letter in string.ascii_uppercase),
    *(f"Digit{number}" for number in range(10)),
)


class Steps(Perception):
    name = "steps"
    summary = "How long it has played."
    state = Box((Field("steps", "1", 0.0, np.inf),))

    def perceive(self, snapshot: Snapshot) -> Percept:
        steps = snapshot["steps"].astype(np.float64)[:, None]
        return Percept(steps, np.zeros((len(steps), 0)))


class Organ(Scene):
    name = "organ"
    title = "An organ"
    version = 1
    dt_s = 1.0 / 15.0
    render_hz = 15.0
    outcomes = ("running", "over")
    successes = frozenset({"over"})
    controls = tuple(Control(code, code, (), (code,), 0.0) for code in CODES)
    look = Look((20, 24, 40), 10.0, 100.0, (0.0, 0.0, -1.0))
    action = Box(tuple(Field(code, "1", 0.0, 1.0) for code in CODES))
    perceptions: Mapping[str, Perception] = {"steps": Steps()}

    def reset(self, rng: np.random.Generator, worlds: int) -> Snapshot:
        return Snapshot({"size": np.ones(worlds)}, {"steps": np.zeros(worlds, dtype=np.int64)})

    def step(self, snapshot: Snapshot, actions: Array) -> Snapshot:
        return snapshot.after(steps=snapshot["steps"] + 1)

    def outcome(self, snapshot: Snapshot) -> NDArray[np.int64]:
        return np.zeros(snapshot.worlds, dtype=np.int64)

    def progress(self, snapshot: Snapshot) -> Array:
        return np.zeros(snapshot.worlds)

    def meshes(self) -> Mapping[str, Mesh]:
        box = trimesh.creation.box((2.0, 4.0, 1.0))
        return {"box": Mesh(np.asarray(box.vertices), np.asarray(box.faces), (180, 150, 90))}

    def bodies(self, snapshot: Snapshot) -> Sequence[Body]:
        place, pose = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
        return [Body("organ", "box", place, pose, np.ones(1), fixed=True)]

    def camera(self, snapshot: Snapshot) -> Camera:
        return Camera(np.array([-8.0, 0.0, 4.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]))
