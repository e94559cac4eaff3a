"""What happened in one world, moment by moment, to look back at and to go on from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evastudio.demonstrations.records import Origin, TakeData, TakeRecord
from evastudio.live.moments import Moments
from evastudio.pilots.why import Why
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

LIFT = 0.06
"""Metres above the ground at which the way of somebody who walks on it is drawn."""
MOST_BYTES = 256 * 2**20
"""Of a longer run the beginning is forgotten."""


class Reel:
    """The moments of a run, one for each decision and the last."""

    def __init__(self, scene: Scene, origin: Origin) -> None:
        """Of a run in `scene` that began as `origin` says."""
        self.scene = scene
        self.origin = origin
        self.key: str | None = None
        """What its recorder calls the take that the whole run is; None where it is none."""
        self._moments = Moments()
        self._reasons: dict[int, Why] = {}
        self._places: dict[int, Array] = {}
        self._steered: set[int] = set()

    @classmethod
    def of_take(cls, scene: Scene, take: TakeRecord, data: TakeData) -> Reel:
        """A take as it was recorded, in the scene with the options it was made in."""
        reel = cls(scene, Origin(0, take=take.id))
        for step in range(data.snapshots.worlds):
            reel.add(data.snapshots.take(slice(step, step + 1)))
        last = data.snapshots.take(slice(-1, None))
        reel.add(scene.step(last, data.actions[-1:]))
        return reel

    def add(self, moment: Snapshot) -> None:
        """What comes next."""
        self._moments.append(moment)
        while self._moments.bytes > MOST_BYTES and (gone := self._moments.forget()):
            for step in gone:
                self._reasons.pop(step, None)
                self._places.pop(step, None)
                self._steered.discard(step)

    @property
    def bytes(self) -> int:
        """What the moments take in memory."""
        return self._moments.bytes

    def note(self, why: Why | None, step: int | None = None) -> None:
        """Why the decision at that step is as it is, the one after the latest moment if None."""
        if why is not None:
            self._reasons[self.last if step is None else step] = why

    def why(self, step: int) -> Why | None:
        """What the decision at that step came from; None where a person or a program decided."""
        return self._reasons.get(step)

    def note_steered(self) -> None:
        """A person decides at the latest moment, who has taken over."""
        self._steered.add(self.last)

    def steered(self, step: int) -> bool:
        """Whether a person decided at that step who had taken over from what plays."""
        return step in self._steered

    def familiarity(self, first: int, last: int) -> list[float | None]:
        """How familiar each decision from `first` to before `last` was; see `Why`."""
        found = (self._reasons.get(step) for step in range(first, last))
        return [None if why is None else why.familiarity for why in found]

    @property
    def first(self) -> int:
        """The first step that is remembered."""
        return self._moments.first

    @property
    def last(self) -> int:
        """The step after the last decision."""
        return self.first + len(self._moments) - 1

    def moment(self, step: int) -> Snapshot:
        """As it was at that step, or the nearest one that is remembered."""
        return self._moments[min(max(step, self.first), self.last) - self.first]

    def place(self, step: int) -> Array:
        """Where the lead was at that step, (3,), metres."""
        known = self._places.get(step)
        if known is None:
            known = self._places[step] = places_of(self.scene, self.moment(step))[0]
        return known

    def shown(self, position: float) -> Snapshot:
        """As it looked at `position`, in steps: between two moments as a view drew it."""
        position = min(max(position, self.first), self.last)
        step = int(position)
        if step == position:
            return self.moment(step)
        return self.scene.interpolate(self.moment(step), self.moment(step + 1), position - step)

    def moments(self) -> Sequence[Snapshot]:
        """Those that are remembered by now, from `first` to `last`; for any thread."""
        return self._moments.as_they_are()

    def origin_at(self, step: int) -> Origin:
        """How a take that goes on from that step says where it came from."""
        return self.origin.later(step)


def places_of(scene: Scene, worlds: Snapshot) -> Array:
    """Where the lead is in each of `worlds`, (worlds, 3), metres."""
    at = scene.whereabouts(worlds)
    return at if at.shape[1] == 3 else np.c_[at, np.full(len(at), LIFT)]
