"""Scenes whose people are drawn walking between two decisions, however far apart those are.

Their ground may have no edge: who leaves on one side comes back on the other, while positions add
up. Snapshots hold, beside what `Peopled` asks for, of N people:

| state   | shape     | meaning                                                               |
|---------|-----------|-----------------------------------------------------------------------|
| size    | (N,)      | 1 is 1.75 m tall; fixed                                               |
| speed   | (N,)      | in the last step, m/s                                                 |
| phase   | (N,)      | cycles walked so far, for the swing of the legs                       |
| cadence | (N,)      | cycles a second in the last step                                      |
| feet    | (N, 2, 3) | where the left and the right foot stand, or stood last: x, y and      |
|         |           | heading of its track                                                  |
| brisk   | (N,)      | how much of the last ten steps or so one walked, 0 to 1               |
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evastudio.motion.easing import smooth
from evastudio.motion.figures import figures
from evastudio.motion.footing import NOTICED, REST, Passage, at_home, complex_of, settling
from evastudio.motion.peopled import Peopled
from evastudio.world.snapshot import AnyArray, Snapshot
from evastudio.world.spaces import Array

REMEMBERED = 20.0
"""Steps over which it is remembered how much somebody walked."""
MANNERED = (0.5, 0.7)
"""Shares of steps walked at which a walk is a shy one, and a hurried one."""


class Walkers(Peopled):
    """See the module's docstring."""

    ground: float
    """Metres after which the ground comes again."""

    def standing(
        self, rng: np.random.Generator, position: AnyArray, heading: AnyArray
    ) -> dict[str, AnyArray]:
        """Legs of people who stand there, each in a rhythm of their own."""
        shape = heading.shape
        return {
            "speed": np.zeros(shape),
            "phase": rng.integers(2, size=shape) / 2 + 2 * REST * rng.random(shape),
            "cadence": np.zeros(shape),
            "feet": at_home(position, heading),
            "brisk": np.full(shape, 0.5 * (MANNERED[0] + MANNERED[1])),
        }

    def walked(self, before: Snapshot, after: Snapshot, down: NDArray[np.bool_]) -> Snapshot:
        """`after`, with how legs got there; who is `down`, (worlds, N), does not stand on them."""
        speed, size, phase = after["speed"], after["size"], before["phase"]
        turn_rate = (after["heading"] - before["heading"]) / self.dt_s
        cycles = figures().cadence(speed, turn_rate, size, manners(before)) * self.dt_s
        stands = (speed == 0.0) & (turn_rate == 0.0)
        cycles[stands] = settling(
            before["feet"][stands],
            after["position"][stands],
            after["heading"][stands],
            phase[stands],
        )
        after = after.after(
            phase=phase + cycles,
            cadence=cycles / self.dt_s,
            brisk=before["brisk"] + ((speed > 0.0) - before["brisk"]) / REMEMBERED,
        )
        shifted = self._shifted(before, after)
        feet = self._passage(shifted, after).landed(shifted["feet"])
        feet[down] = at_home(after["position"][down], after["heading"][down])
        return after.after(feet=feet)

    def nearest_image(self, snapshot: Snapshot) -> Array:
        """Positions (worlds, N, 2), shifted by whole grounds to where they are nearest the lead."""
        position = snapshot["position"]
        lead = position[np.arange(snapshot.worlds), snapshot["lead"]][:, None]
        return np.asarray(position - np.rint((position - lead) / self.ground) * self.ground)

    def interpolate(self, before: Snapshot, after: Snapshot, fraction: float) -> Snapshot:
        before = self._shifted(before, after)
        way = self._passage(before, after)
        footing = way.footing(fraction, before["feet"], after["feet"])
        eased = {
            name: before[name]
            + (after[name] - before[name]) * smooth(np.asarray(fraction / NOTICED))
            for name in ("speed", "cadence")
        }
        return (
            super()
            .interpolate(before, after, fraction)
            .after(
                **eased,
                position=way.position(fraction),
                heading=way.heading(fraction),
                turn_rate=way.turn_rate(fraction),
                feet=footing.stood,
                aims=footing.aims,
            )
        )

    def striding(self, world: Snapshot) -> Snapshot:
        """`world` with `aims`, where each foot comes down next.

        At a decision, and not between two, it is as if all went on as they do.
        """
        if "aims" in world.moving:
            return world
        on = world["speed"][:, :, None] * np.stack(
            [np.cos(world["heading"]), np.sin(world["heading"])], axis=2
        )
        then = world.after(
            position=world["position"] + on * self.dt_s,
            phase=world["phase"] + world["cadence"] * self.dt_s,
        )
        return self.interpolate(world, then, 0.0)

    def _shifted(self, before: Snapshot, after: Snapshot) -> Snapshot:
        """`before`, by whole grounds to where it is nearest `after`."""
        grounds = np.rint((after["position"] - before["position"]) / self.ground)
        shift = grounds * self.ground
        if not shift.any():
            return before
        feet = before["feet"].copy()
        feet[..., :2] += shift[:, :, None]
        return before.after(position=before["position"] + shift, feet=feet)

    def _passage(self, before: Snapshot, after: Snapshot) -> Passage:
        """From one decision to the next."""
        return Passage(
            figures(),
            self.dt_s,
            complex_of(before["position"]),
            complex_of(after["position"]),
            before["speed"] * np.exp(1j * before["heading"]),
            (before["heading"], after["heading"]),
            (before["phase"], after["phase"]),
            after["size"],
            manners(before),
        )


def manners(snapshot: Snapshot) -> Array:
    """How people walk, (worlds, N), from shy, -1, to hurried, 1: by how much they do it."""
    low, high = MANNERED
    return np.clip(2.0 * (snapshot["brisk"] - low) / (high - low) - 1.0, -1.0, 1.0)
