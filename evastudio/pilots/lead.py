"""One pilot for the lead of a scene of many characters, and another, or none, for the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from evastudio.world.cast import for_all, of_lead
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

_OTHERS = "others."


class LeadPilot(Pilot):
    """`lead` acts for the lead alone; the others do as `others` says, or rest where it is None.

    In a scene of one character it is `lead`.
    """

    def __init__(self, lead: Pilot, others: Pilot | None = None) -> None:
        self.lead = lead
        self.others = others
        self.name = lead.name

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        theirs: Mapping[str, Array] = {}
        if self.others is not None:
            theirs = self.others.begin(scene, seeds)
        named = {_OTHERS + name: array for name, array in theirs.items()}
        return {**self.lead.begin(scene, seeds), **named}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        own = {name: array for name, array in memory.items() if not name.startswith(_OTHERS)}
        actions, after = self.lead.act(scene, snapshot, own)
        if not scene.characters:
            return actions, after
        others = None
        if self.others is not None:
            known = {
                name.removeprefix(_OTHERS): array
                for name, array in memory.items()
                if name.startswith(_OTHERS)
            }
            others, left = self.others.act(scene, snapshot, known)
            after = {**after, **{_OTHERS + name: array for name, array in left.items()}}
        return for_all(scene, snapshot, of_lead(snapshot, actions), others), after
