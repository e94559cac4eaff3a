"""A clip: how the joints of a skeleton move, in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.motion.rotations import continuous, normalized, slerp
from evastudio.motion.skeleton import LARGEST, Skeleton
from evastudio.world.spaces import Array

MOST_VALUES = 8_000_000
"""Numbers that one clip may hold: 64 MB, or a quarter of an hour of 41 joints at 30 a second."""


def fitting(name: str, frames: int, joints: int) -> None:
    """Raise InvalidInputError unless a clip of that size may be made: before it is allocated."""
    if frames * joints * 7 > MOST_VALUES or frames < 2:
        raise InvalidInputError(
            f"Clip {name!r} claims {frames} moments of {joints} joints; it may have 2 to "
            f"{MOST_VALUES // (7 * max(joints, 1))}. Export a shorter part, or fewer a second."
        )


@dataclass(frozen=True)
class Clip:
    """Moments of one movement, evenly spaced. Raises InvalidInputError where they make none."""

    name: str
    skeleton: Skeleton
    rate_hz: float
    """Moments a second."""
    translations: Array
    """Shape (F, J, 3): each joint in its parent's frame, in the units of the file it came from."""
    rotations: Array
    """Shape (F, J, 4), unit quaternions in the parent's frame, of signs that do not jump."""

    def __post_init__(self) -> None:
        frames, joints = len(self.rotations), len(self.skeleton.names)
        if frames < 2 or not np.isfinite(self.rate_hz) or self.rate_hz <= 0:
            raise InvalidInputError(
                f"Clip {self.name!r} has {frames} moments at {self.rate_hz} a second; it needs at "
                "least two, at a rate above zero."
            )
        for name, array, width in (
            ("translations", self.translations, 3),
            ("rotations", self.rotations, 4),
        ):
            if array.shape != (frames, joints, width):
                raise InvalidInputError(
                    f"The {name} of clip {self.name!r} have shape {array.shape}; expected "
                    f"{(frames, joints, width)}."
                )
            if not (np.abs(array) <= LARGEST).all():
                raise InvalidInputError(
                    f"The {name} of clip {self.name!r} hold NaN, or numbers beyond {LARGEST:g}, "
                    "which cannot be played."
                )
        if ((self.rotations**2).sum(axis=-1) < 1e-6).any():
            raise InvalidInputError(
                f"Clip {self.name!r} holds quaternions of length zero, which turn nothing; export "
                "it anew."
            )
        object.__setattr__(self, "rotations", continuous(normalized(self.rotations)))

    @property
    def duration_s(self) -> float:
        """From the first moment to the last."""
        return (len(self.rotations) - 1) / self.rate_hz

    def sample(self, times_s: Array) -> tuple[Array, Array]:
        """Local translations (N, J, 3) and rotations (N, J, 4) at `times_s` (N,).

        Times outside the clip show its first or last moment.
        """
        last = len(self.rotations) - 1
        place = np.clip(np.asarray(times_s) * self.rate_hz, 0, last)
        before = np.minimum(place.astype(np.int64), last - 1)
        share = (place - before)[:, None]
        translations = self.translations[before]
        translations = translations + share[..., None] * (
            self.translations[before + 1] - translations
        )
        turned = slerp(self.rotations[before], self.rotations[before + 1], share)
        return translations, turned

    def world(self) -> tuple[Array, Array]:
        """Positions (F, J, 3) and orientations (F, J, 4) of all joints at every moment."""
        return self.skeleton.posed(self.translations, self.rotations)
