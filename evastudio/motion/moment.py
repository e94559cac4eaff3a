"""What the characters of a crowd do at one moment."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.spaces import Array


class Activity(IntEnum):
    """What a character does. The first four differ by speed and turning alone."""

    STAND = 0
    WALK = 1
    TURN = 2
    RUN = 3
    STAGGER = 4
    FALLEN = 5
    GETTING_UP = 6


def zero() -> Array:
    return np.zeros(())


def one() -> Array:
    return np.ones(())


def whole_zero() -> NDArray[np.int64]:
    return np.zeros((), dtype=np.int64)


@dataclass(frozen=True)
class Footing:
    """Where the feet of N characters are, as `footing.py` finds it."""

    stood: Array
    """Shape (N, 2, 3), left and right: x, y and heading of the track on which each foot stands,
    or stood before it rose."""
    aims: Array
    """Shape (N, 2, 3): where each comes down next."""


@dataclass(frozen=True)
class Moment:
    """What N characters do at one moment; arrays of shape () are for all of them."""

    positions: Array
    """Shape (N, 2) or (N, 3), metres: the ground under each."""
    headings: Array
    """Shape (N,), rad from x to y."""
    speeds: Array = field(default_factory=zero)
    """Metres a second, ahead."""
    phases: Array = field(default_factory=zero)
    """Cycles of walking so far: the integral of `Figures.cadence`; any start will do."""
    turn_rates: Array = field(default_factory=zero)
    """Radians a second, to the left."""
    activities: NDArray[np.int64] = field(default_factory=whole_zero)
    """`Activity`."""
    since_s: Array = field(default_factory=zero)
    """Seconds since the activity began; it matters to those beyond walking."""
    times_s: Array = field(default_factory=zero)
    """The world's clock, which breathing follows; a shift for each character keeps them apart."""
    sizes: Array = field(default_factory=one)
    """1 is 1.75 m tall."""
    manners: Array = field(default_factory=zero)
    """From -1, shy, to 1, hurried."""
    looks: NDArray[np.int64] = field(default_factory=whole_zero)
    """Clothes, hair, skin and build, by number."""
    cadences: Array | None = None
    """Cycles a second, where these are others than `Figures.cadence` tells; 0 for who stands."""
    footing: Footing | None = None
    """Where feet are; where it is None they are as if speed and turning had always been these."""

    def __post_init__(self) -> None:
        count = len(self.positions)
        if np.ndim(self.positions) != 2 or np.shape(self.positions)[1] not in (2, 3):
            raise InvalidInputError(
                f"The positions have shape {np.shape(self.positions)}; expected (N, 2) or (N, 3)."
            )
        if not np.isfinite(self.positions).all():
            raise InvalidInputError("The positions hold NaN or infinite numbers.")
        for entry in fields(self)[1:]:
            if entry.name == "footing" or getattr(self, entry.name) is None:
                continue
            array = np.asarray(getattr(self, entry.name))
            if array.shape not in ((), (count,)):
                raise InvalidInputError(
                    f"The {entry.name} have shape {array.shape}; expected ({count},), one for "
                    "each character."
                )
            if not np.isfinite(array).all() or (entry.name == "sizes" and not (array > 0).all()):
                raise InvalidInputError(
                    f"The {entry.name} hold NaN, infinite numbers, or sizes that are not above "
                    "zero; a figure needs finite ones."
                )
            kind = np.int64 if entry.name in ("activities", "looks") else np.float64
            wide = np.broadcast_to(array.astype(kind, copy=False), (count,))
            object.__setattr__(self, entry.name, wide)
        if self.footing is not None:
            for feet in (self.footing.stood, self.footing.aims):
                if feet.shape != (count, 2, 3) or not np.isfinite(feet).all():
                    raise InvalidInputError(
                        f"The footing has shape {feet.shape}; expected finite numbers of shape "
                        f"({count}, 2, 3), three for each foot."
                    )
