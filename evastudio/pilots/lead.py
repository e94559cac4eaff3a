"""One pilot for the lead of a scene of many characters, and another, or none, for the rest."""

from __future__ import annotations

from collections.abc import Sequence

from evastudio.pilots.memories import named, within
from evastudio.world.cast import for_all, of_lead
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

_LEAD, _OTHERS = "lead.", "others."


class LeadPilot(Pilot):
    """`lead` acts for the lead alone; the others do as `others` says, or rest where it is None.

    In a scene of one character it is `lead`.
    """

    def __init__(self, lead: Pilot, others: Pilot | None = None) -> None:
        self.lead = lead
        self.others = others
        self.name = lead.name

    def begin(self, scene: Scene, seeds: Sequence[int]) -> Memory:
        theirs: Memory = {}
        if self.others is not None:
            theirs = self.others.begin(scene, seeds)
        return {**named(_LEAD, self.lead.begin(scene, seeds)), **named(_OTHERS, theirs)}

    def act(self, scene: Scene, snapshot: Snapshot, memory: Memory) -> tuple[Array, Memory]:
        actions, own = self.lead.act(scene, snapshot, within(_LEAD, memory))
        after = named(_LEAD, own)
        if not scene.characters:
            return actions, after
        others = None
        if self.others is not None:
            others, theirs = self.others.act(scene, snapshot, within(_OTHERS, memory))
            after = {**after, **named(_OTHERS, theirs)}
        return for_all(scene, snapshot, of_lead(snapshot, actions), others), after
