"""Between the paper's state and `canonical`: a demonstrator who needs no more, and other states.

For the study in docs/reproduction.md; `benchmarks/plain_state.py` puts them into the scene.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evastudio.world.rocks import rocks_within, smallest
from evastudio.world.scene import Percept, Perception
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box, Field

Axes = tuple[Array, Array, Array]
"""Forward, left and up of ships, each of shape (worlds, 3)."""
SEEN = 60.0
"""Metres to which rocks ahead are looked for."""


def turn_away(
    states: Array,
    axes: Axes,
    reach: float,
    *,
    strength: float = 0.4,
    homing: float = 0.12,
) -> Array:
    """A skilled answer to the paper's `states` (worlds, 8), from nothing else; (worlds, 2), rad.

    As the scene's `intention`, but of the two nearest rocks: each that is not behind pushes
    aside, the more the nearer it is to the way flown. Distances count in units of `reach`, that
    at which ship and rock touch. The ship is held straight, for where it is the state is silent.
    """
    rocks = own_frame(-states[:, 2:].reshape(-1, 2, 3), axes)
    ahead, lateral = rocks[:, :, 0], rocks[:, :, 1:]
    aside = np.sqrt((lateral**2).sum(axis=2))
    close = np.clip(1.0 - (aside - reach) / (2.0 * reach), 0.0, 1.0)
    close *= np.exp(-np.maximum(ahead, 0.0) / (6.0 * reach)) * np.clip(ahead / reach + 1.0, 0, 1)
    away = -lateral / np.maximum(aside, 1e-9)[:, :, None]
    return np.asarray(strength * (close[:, :, None] * away).sum(axis=1) - homing * states[:, :2])


def own_frame(vectors: Array, axes: Axes) -> Array:
    """`vectors` (worlds, N, 3) of the world along the ship's `axes`."""
    return np.stack([(vectors * axis[:, None]).sum(axis=2) for axis in axes], axis=2)


class TwoRocks(Perception):
    """The paper's state, changed in one respect or several."""

    def __init__(self, plain: Perception, reach: float, *changes: str) -> None:
        """`plain` is the paper's own perception; `changes` are among CHANGES."""
        self.name = ", ".join(changes)  # type: ignore[misc]
        self.summary = "For the reproduction study."  # type: ignore[misc]
        self._plain, self._reach, self._changes = plain, reach, changes
        rocks = [f"{axis}{rock}" for rock in (1, 2) for axis in ("x", "y", "z")]
        self.state = Box(
            (*plain.state.fields[:2], *(Field(name, "m", -np.inf, np.inf) for name in rocks))
        )

    def perceive(self, snapshot: Snapshot) -> Percept:
        heading = snapshot["heading"]
        axes = ship_axes(heading)
        if "ahead" in self._changes:
            rocks = two_ahead(snapshot, axes[0])
        else:
            rocks = -self._plain.perceive(snapshot).states[:, 2:].reshape(-1, 2, 3)
        if "own frame" in self._changes:
            rocks = own_frame(rocks, axes)
        if "fading" in self._changes:
            away = np.sqrt((rocks**2).sum(axis=2, keepdims=True))
            near = np.exp(-np.maximum(away - self._reach, 0.0) / (2.0 * self._reach))
            rocks = rocks / np.maximum(away, 1e-9) * near
        states = np.concatenate([heading, rocks.reshape(-1, 6)], axis=1)
        return Percept(states, np.zeros((len(states), 0)))


CHANGES: Mapping[str, str] = {
    "own frame": "seen from the ship",
    "fading": "a direction that fades with distance",
    "ahead": "the two nearest that are not behind",
}
"""What can be other than the paper has it."""
LADDER = (
    ("own frame",),
    ("fading",),
    ("ahead",),
    ("own frame", "fading"),
    ("own frame", "fading", "ahead"),
)
"""Which changes are tried together."""


def ladder(plain: Perception, reach: float) -> dict[str, Perception]:
    """The states between, by name."""
    views = [TwoRocks(plain, reach, *changes) for changes in LADDER]
    return {view.name: view for view in views}


def two_ahead(snapshot: Snapshot, forward: Array) -> Array:
    """The two nearest rocks that are not behind, from the ship; far to the side where none are."""
    box = np.full((snapshot.worlds, 3), SEEN / 2)
    x, y, z, present = rocks_within(snapshot, -box, box)
    ahead = x * forward[:, :1] + y * forward[:, 1:2] + z * forward[:, 2:]
    square = np.where(present & (ahead > 0.0), x**2 + y**2 + z**2, np.inf)
    index = smallest(square, 2)
    near = np.stack([np.take_along_axis(axis, index, axis=1) for axis in (x, y, z)], axis=2)
    exists = np.take_along_axis(square, index, axis=1) < np.inf
    return np.where(exists[:, :, None], near, (0.0, SEEN, 0.0))


def ship_axes(heading: Array) -> Axes:
    """Forward, left and up of ships with `heading` (worlds, 2), as the scene has them."""
    cosine, sine = np.cos(heading), np.sin(heading)
    zero = np.zeros(len(heading))
    return (
        np.stack([cosine[:, 1] * cosine[:, 0], cosine[:, 1] * sine[:, 0], sine[:, 1]], axis=1),
        np.stack([-sine[:, 0], cosine[:, 0], zero], axis=1),
        np.stack([-sine[:, 1] * cosine[:, 0], -sine[:, 1] * sine[:, 0], cosine[:, 1]], axis=1),
    )
