"""Where feet are put: from one decision to the next, so that none slides whatever comes after.

A character that decides twice a second starts, stops and turns at once; a body does not. Between
two decisions its path is a smooth curve that begins as fast as the last one ended. A foot that
stands is left where it stands, and one that swings is led to where the body will be above it,
which is found anew at every moment as the future becomes known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evastudio.motion.easing import smooth
from evastudio.motion.figures import SLOWEST_HZ, Figures
from evastudio.motion.moment import Footing
from evastudio.motion.rotations import Numbers
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Array

TOUCHDOWNS = np.array([0.0, 0.5])
"""Phases at which the left and the right foot begin to stand."""
REST = 0.05
"""Both feet stand at this phase, half a cycle later, and a little before and after."""
SHORTEST = 0.3
"""Share of a cycle that every foot stands at least."""
LEAST = 0.3
"""Cycles, at least, in which who has stopped brings the feet together."""
NEAR = (0.05, 0.15)
"""Metres and radians from where it belongs at which a foot may stay."""
NOTICED = 0.4
"""Share of the time between two decisions over which feet and pace follow the new one."""


Places = NDArray[np.complex128]
"""x + iy: half the work of two columns."""


@dataclass(frozen=True)
class Passage:
    """How characters get from one decision to the next. Any leading axes, written `...`."""

    figures: Figures
    """Whose steps they are."""
    dt_s: float
    start: Places
    """Shape (...), metres, x + iy; `complex_of` makes it."""
    end: Places
    """Shape (...)."""
    entering: Places
    """Shape (...), metres a second at the start."""
    headings: tuple[Array, Array]
    """At the start and at the end, (...), rad."""
    phases: tuple[Array, Array]
    """Cycles at the start and at the end, (...)."""
    sizes: Array
    manners: Array

    def place(self, share: Numbers | float) -> tuple[Places, Places]:
        """Positions and velocities (...) when `share` of the time has passed."""
        u, first, whole = np.asarray(share), self.entering * self.dt_s, self.end - self.start
        rest = 1.0 - u
        position = self.start + first * (u * rest * rest) + whole * (u * u * (2.0 - u))
        velocity = first * (rest * (1.0 - 3.0 * u)) + whole * (u * (4.0 - 3.0 * u))
        return position, velocity / self.dt_s

    def position(self, share: float) -> Array:
        """Where they are, (..., 2)."""
        at = self.place(share)[0]
        return np.stack([at.real, at.imag], axis=-1)

    def heading(self, share: Numbers | float) -> Array:
        """Where they face (...)."""
        before, after = self.headings
        return np.asarray(before + (after - before) * smooth(np.asarray(share)))

    def turn_rate(self, share: float) -> Array:
        """Radians a second (...)."""
        before, after = self.headings
        return np.asarray((after - before) * (6.0 * share * (1.0 - share)) / self.dt_s)

    def phase(self, share: float) -> Array:
        """Cycles (...)."""
        return np.asarray(self.phases[0] + (self.phases[1] - self.phases[0]) * share)

    def landed(self, feet: Array) -> Array:
        """Where each foot stands, or stood last, at the end: `feet` (..., 2, 3) of the start.

        x, y and where it points, of the track that the foot belongs to.
        """
        lands = self._lands()
        these = lands <= 1.0
        found = feet.copy()
        found[these] = self._of(these)._aims(lands[these], lands[these])
        return found

    def footing(self, share: float, before: Array, after: Array) -> Footing:
        """What feet do when `share` has passed; `before` and `after` as of `landed`."""
        lands = self._lands()
        landed = lands <= share
        stood = np.where(landed[..., None], after, before)
        lands = np.where(landed, lands + 1.0 / self._cycles()[..., None], lands)
        swings = np.mod(self.phase(share)[..., None] - TOUCHDOWNS, 1.0) > SHORTEST
        aims = stood.copy()
        aims[swings] = self._of(swings)._aims(share, lands[swings])
        return Footing(stood, aims)

    def _cycles(self) -> Array:
        return np.maximum(self.phases[1] - self.phases[0], 1e-9)

    def _lands(self) -> Array:
        """Share of the time, or more than 1, after which each foot comes down, (..., 2)."""
        before = self.phases[0][..., None] - TOUCHDOWNS
        return np.asarray((np.floor(before) + 1.0 - before) / self._cycles()[..., None])

    def _of(self, feet: NDArray[np.bool_]) -> Passage:
        """The passages of the bodies that `feet` (..., 2) belong to, in one row."""
        whose = np.nonzero(feet)[:-1]
        return Passage(
            self.figures,
            self.dt_s,
            self.start[whose],
            self.end[whose],
            self.entering[whose],
            (self.headings[0][whose], self.headings[1][whose]),
            (self.phases[0][whose], self.phases[1][whose]),
            self.sizes[whose],
            self.manners[whose],
        )

    def _aims(self, share: Numbers | float, lands: Array) -> Array:
        """Where a foot of each is led to, (..., 3), at `share`; it comes down at `lands`.

        It will stand where the body is half way through the time that it stands. At first that
        is told by the speed alone, and soon by what was decided; but a foot that is about to come
        down does not turn aside any more.
        """
        late = np.minimum(share / lands, 1.0)
        heeded = lands * smooth(lands / NOTICED) * late * (2.0 - late)
        share = np.where(lands <= 1.0, heeded, share)
        cycles = self._cycles()
        position, velocity = self.place(share)
        speed = np.abs(velocity)
        ahead = (lands - share) * cycles + standing(speed / self.sizes) / 2
        told = position + velocity * (ahead / self._natural(speed))
        then = np.minimum(share + ahead / cycles, 3.0)
        inside = np.minimum(then, 1.0)
        known = self.place(inside)[0] + (self.end - self.start) * (then - inside)
        weight = smooth(share / NOTICED)
        at = told + (known - told) * weight
        facing = self.heading(share)
        facing = facing + (self.heading(inside) - facing) * weight
        return np.stack([at.real, at.imag, facing], axis=-1)

    def _natural(self, speeds: Array) -> Array:
        slowest = SLOWEST_HZ  # who hardly moves must not take a whole step
        return np.maximum(self.figures.cadence(speeds, 0.0, self.sizes, self.manners), slowest)


def complex_of(vectors: AnyArray) -> Places:
    """Vectors (..., 2) as x + iy, (...)."""
    return np.ascontiguousarray(vectors).view(np.complex128)[..., 0]


def standing(speeds: Numbers) -> Array:
    """Share of a cycle that a foot stands, at `speeds` of size 1."""
    return np.asarray(np.interp(speeds, [0.0, 1.8, 2.6], [0.62, 0.58, 0.36]))


def at_home(position: AnyArray, heading: AnyArray) -> Array:
    """Both feet under the body, (..., 2, 3)."""
    home = np.concatenate([position, heading[..., None]], axis=-1)
    return np.repeat(home[..., None, :], 2, axis=-2)


def settling(feet: Array, position: Array, heading: Array, phase: Array) -> Array:
    """Cycles (...) that who stands still needs to bring the `feet` home; 0 where they are."""
    away = feet - at_home(position, heading)
    near = (np.hypot(away[..., 0], away[..., 1]) < NEAR[0]) & (np.abs(away[..., 2]) < NEAR[1])
    rests = np.mod(phase, 0.5) <= 2 * REST
    after = np.ceil((phase + LEAST - REST) * 2.0) / 2.0 + REST
    return np.where(near.all(axis=-1) & rests, 0.0, after - phase)
