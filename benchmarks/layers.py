"""A network that another library made, as a pilot; its arrays lie in `benchmarks/trained/`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


class Layers(Pilot):
    """A network of tanh layers, the last one linear, on standardised states of `perception`."""

    name = "layers"

    def __init__(self, perception: str, arrays: dict[str, Array]) -> None:
        """`arrays`: `offset` and `scale` of the states, then `weights_0`, `biases_0`, ..., whose
        actions are shares of the largest."""
        self.perception, self.arrays = perception, arrays
        self.depth = sum(name.startswith("weights") for name in arrays)

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        view = scene.perception(self.perception)
        percept = view.perceive(snapshot)
        values = (percept.states - self.arrays["offset"]) / self.arrays["scale"]
        for number in range(self.depth):
            values = values @ self.arrays[f"weights_{number}"].T + self.arrays[f"biases_{number}"]
            values = values if number == self.depth - 1 else np.tanh(values)
        actions = np.clip(values, -1.0, 1.0) * scene.action.high
        return view.to_world(percept.frame, actions), memory

    def save(self, path: Path) -> None:
        """Its arrays as npz; no pickle."""
        np.savez(path, **self.arrays)

    @classmethod
    def load(cls, perception: str, path: Path) -> Layers:
        """Those of a file that `save` wrote."""
        with np.load(path) as arrays:
            return cls(perception, dict(arrays))
