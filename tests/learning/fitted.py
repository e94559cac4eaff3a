"""Policies of every learner, fitted to a few pairs, and their files."""

import json
import struct
from pathlib import Path

import numpy as np

from evastudio.demonstrations.pairs import Pairs
from evastudio.learning.cleaning import clean_pairs
from evastudio.learning.fitting import fit_policy
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.spaces import Symbols

SETTINGS = {
    "knn": {"k": 3, "weights": "distance"},
    "svr": {"C": 5.0},
    "compact": {"bases": 9},
    "local-linear": {"k": 7},
    "sampled": {"k": 4, "link": 0.02},
    "mlp": {"hidden": 5, "iterations": 20},
    "voting": {"k": 3},
    "sampled-voting": {"k": 3},
    "quantized-svr": {"C": 5.0},
    "quantized-knn": {"k": 3},
}
"""Of each learner and of a compact SVR."""


def scene_of(kind):
    """A scene whose actions that kind of learner learns."""
    if kind.endswith("voting") or kind.startswith("quantized"):
        return load_scene_file(Path(__file__).parent.parent / "scenes" / "walker.py")()
    return load_scene_file(shipped() / "scenes" / "asteroids.py")()


def some_pairs(scene, count=60, perception=None):
    rng = np.random.default_rng(count)
    size = scene.perception(perception).state.size
    states = rng.uniform(-1, 1, size=(count, size))
    actions = 0.1 * np.sin(states[:, :2])
    if isinstance(scene.action, Symbols):
        actions = 2.0 + np.sign(states[:, :1])
    return Pairs(states, actions, np.repeat([4, 9], count // 2), np.arange(count))


def some_policy(kind="svr", count=60):
    scene = scene_of(kind)
    pairs = some_pairs(scene, count)
    return fit_policy(
        pairs,
        scene,
        None,
        "svr" if kind == "compact" else kind,
        SETTINGS[kind],
        session=7,
        cleaning=clean_pairs(pairs, scene),
        made_by="evastudio fit 7",
        created="2030-01-02T03:04:05+00:00",
    )


def states_for(policy, count=40):
    return np.random.default_rng(count).uniform(-1, 1, size=(count, policy.state.size))


def rewritten(path, change):
    """The file at `path` with its description put through `change`."""
    data = path.read_bytes()
    size = int.from_bytes(data[:8], "little")
    outer = json.loads(data[8 : 8 + size])
    header = json.loads(outer["__metadata__"]["evastudio"])
    change(header)
    outer["__metadata__"]["evastudio"] = json.dumps(header)
    packed = json.dumps(outer).encode()
    packed += b" " * (-len(packed) % 8)
    path.write_bytes(struct.pack("<Q", len(packed)) + packed + data[8 + size :])
    return path
