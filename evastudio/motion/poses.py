"""Poses of the shipped body, in the frame of the path it walks on."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.body import SOLES
from evastudio.motion.rotations import continuous, normalized, rotated
from evastudio.world.spaces import Array


@dataclass(frozen=True)
class Poses:
    """What the parts of a body of size 1 do at F moments; x ahead, y left, z up, metres.

    Legs are given by where their feet are, so that feet can be kept where they stand; two-bone
    inverse kinematics finds the knees.
    """

    root: Array
    """Shape (F, 3): the middle of the hips."""
    upper: Array
    """Shape (F, 9, 4): rotations of `body.UPPER`."""
    ankles: Array
    """Shape (F, 2, 3): left and right."""
    feet: Array
    """Shape (F, 2, 4): orientations of the feet in the path's frame."""
    hinges: Array
    """Shape (F, 2, 3): the axes about which the knees bend, pointing left."""

    def __post_init__(self) -> None:
        frames = len(self.root)
        if frames < 2:
            raise InvalidInputError(f"There are {frames} poses; a movement needs at least two.")
        shapes = ((3,), (9, 4), (2, 3), (2, 4), (2, 3))
        for entry, shape in zip(fields(self), shapes, strict=True):
            array = getattr(self, entry.name)
            if array.shape != (frames, *shape) or not np.isfinite(array).all():
                raise InvalidInputError(
                    f"The {entry.name} of the poses have shape {array.shape}; expected finite "
                    f"numbers of shape {(frames, *shape)}."
                )
        for name in ("upper", "feet"):
            turns = continuous(normalized(getattr(self, name)))
            mostly = np.where(turns[..., :1].mean(axis=0, keepdims=True) < 0, -1.0, 1.0)
            object.__setattr__(self, name, turns * mostly)

    def __len__(self) -> int:
        return len(self.root)

    def soles(self) -> Array:
        """Where heel and ball of both feet are, shape (F, 2, 2, 3)."""
        return self.ankles[:, :, None] + rotated(self.feet[:, :, None], SOLES)

    def at(self, places: Array) -> Poses:
        """Poses between the moments: `places` (N,) counts moments, and stops at both ends."""
        last = len(self) - 1
        places = np.clip(places, 0, last)
        before = np.minimum(places.astype(np.int64), last - 1)
        share = places - before
        mixed = []
        for entry in fields(self):
            array = getattr(self, entry.name)
            weight = share.reshape(-1, *[1] * (array.ndim - 1))
            mixed.append(array[before] * (1 - weight) + array[before + 1] * weight)
        return Poses(*mixed)
