"""Recordings made by people, as pairs, read from a folder outside the repository.

Each is checked against the counts that the folder's README states, so that figures made from
them mean what their captions say.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.push import Perception
from evastudio.demonstrations.pairs import Pairs
from evastudio.world.spaces import Array

ROOT = Path(__file__).resolve().parents[2]
VARIABLE = "EVASTUDIO_DATA"
PUSH = Path("pusht", "pusht_lowdim.npz")
PUSH_SHAPES = {"state": (25650, 5), "action": (25650, 2), "episode_ends": (206,)}


@dataclass(frozen=True)
class Recording:
    """State-action pairs that people made, whole demonstrations one after the other."""

    name: str
    pairs: Pairs
    groups: NDArray[np.int64]
    """What is held out together, shape (pairs,): the demonstration, or the experiment."""
    dt_s: float
    """Seconds from one pair to the next within a take."""


def data_folder() -> Path:
    """Where the recordings lie: `EVASTUDIO_DATA`, else `../shared/data` beside the checkout.

    Ends the benchmark with a sentence where there is no such folder.
    """
    chosen = os.environ.get(VARIABLE)
    folder = Path(chosen) if chosen else ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        raise SystemExit(
            f"The recordings of people were looked for in {folder}, and there is no such folder. "
            f"Put them there, or let the environment variable {VARIABLE} name their folder."
        )
    return folder


def read_arrays(path: Path, shapes: dict[str, tuple[int, ...]]) -> list[Array]:
    """The arrays of an npz file, float64, in the order of `shapes`.

    Ends the benchmark where the file is missing, or an array is missing or of another shape.
    """
    try:
        with np.load(path) as held:
            arrays = [np.asarray(held[name], dtype=np.float64) for name in shapes]
    except (OSError, KeyError, ValueError) as error:
        raise SystemExit(f"{path} cannot be read as the recording it should be: {error}.") from None
    for array, (name, shape) in zip(arrays, shapes.items(), strict=True):
        if array.shape != shape:
            raise SystemExit(
                f"`{name}` in {path} has shape {array.shape}, and {shape} was expected: "
                "this is another recording than the one the figures are about."
            )
    return arrays


def pairs_until(states: Array, actions: Array, ends: Array) -> Pairs:
    """Pairs of demonstrations that end before the row numbers `ends`, the last the row count."""
    sizes = np.diff(np.concatenate([[0], ends])).astype(np.int64)
    if (sizes <= 0).any() or sizes.sum() != len(states):
        raise SystemExit(f"Demonstrations end at {ends[-1]:g} and not with row {len(states)}.")
    steps = np.concatenate([np.arange(size) for size in sizes])
    return Pairs(states, actions, np.repeat(np.arange(len(sizes)), sizes), steps)


def read_push(folder: Path, perception: Perception) -> Recording:
    """Push-T under `perception`: 206 demonstrations with a mouse, 25,650 pairs at 10 Hz."""
    states, targets, ends = read_arrays(folder / PUSH, PUSH_SHAPES)
    percept = perception.perceive(states)
    pairs = pairs_until(percept.states, perception.to_own(percept, targets), ends)
    return Recording(f"Push-T, `{perception.name}`", pairs, pairs.takes, 0.1)


def read_door(folder: Path) -> Recording:
    """Opening a door with a 28-joint hand, in VR: 25 demonstrations, 6,729 pairs.

    The hand's simulation takes 5 steps of 2 ms a decision (hand_dapg, `frame_skip`).
    """
    states, actions, ends = read_arrays(
        folder / "adroit_door" / "door_human25.npz",
        {"obs": (6729, 39), "act": (6729, 28), "ends": (25,)},
    )
    pairs = pairs_until(states, actions, ends)
    return Recording("door", pairs, pairs.takes, 0.01)


def read_targets(folder: Path) -> tuple[Array, Array]:
    """Push-T as it was recorded: states (25650, 5) and targets (25650, 2) in the world's frame."""
    states, targets, _ = read_arrays(folder / PUSH, PUSH_SHAPES)
    return states, targets
