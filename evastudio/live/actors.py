"""Who decides in the world of a stage: a person's keys or a pilot, signals, and all the others."""

from __future__ import annotations

from evastudio.live.inputs import Feel, HeldKeys
from evastudio.live.pushing import Pushes
from evastudio.pilots.why import Reasoner, Why
from evastudio.world.cast import for_all, of_lead, sound
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene, Signal
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array


class Actors:
    """The character's keys, the pilot that acts instead of them, and who acts for the others."""

    def __init__(self, scene: Scene, feel: Feel | None = None) -> None:
        self._scene = scene
        self.keys = HeldKeys(scene.controls, scene.action, scene.dt_s, feel)
        self.pilot: Pilot | None = None
        """Acts for everybody; None where keys decide."""
        self.reasoner: Reasoner | None = None
        """Tells why the pilot decides as it does, where that can be told."""
        self.others: Pilot | None = None
        """Acts for all but the lead while keys decide; None where the others rest."""
        self.gave_way: Pilot | None = None
        """Acted for everybody until a person took over."""
        self.pushes: Pushes | None = None
        """Force the lead off its way now and then, while keys decide; None where they do not."""
        self._memory: Memory = {}
        self._signalled: dict[int, float] = {}

    @property
    def playing(self) -> str | None:
        """Name of who acts for everybody, or did before a person took over."""
        pilot = self.pilot or self.gave_way
        return None if pilot is None else pilot.name

    def take_over(self) -> None:
        """Keys decide for the lead from now on, and the pilot for the others."""
        self.gave_way, self.pilot = self.pilot, None
        self.others = self.gave_way if self._scene.characters else None

    def hand_back(self) -> None:
        """Undo `take_over`."""
        self.pilot, self.gave_way, self.others = self.gave_way, None, None

    def give(self, signal: Signal, place: tuple[float, float] | None) -> None:
        """Let the next decision hold `signal`, meant at `place` where it has one."""
        fields, high = self._scene.action.names, self._scene.action.high
        index = fields.index(signal.field)
        self._signalled[index] = float(high[index])
        if place is not None and signal.place is not None:
            for field, value in zip(signal.place, place, strict=True):
                self._signalled[fields.index(field)] = value

    def enter(
        self,
        pilot: Pilot | None = None,
        others: Pilot | None = None,
        memory: Memory | None = None,
        reasoner: Reasoner | None = None,
        pushes: Pushes | None = None,
    ) -> None:
        """A new world: who acts in it, with the memory that they begin with."""
        self.pilot, self.others, self._memory = pilot, others, dict(memory or {})
        self.reasoner, self.pushes = reasoner, pushes
        self.gave_way = None
        self._signalled = {}

    def why(self, snapshot: Snapshot) -> Why | None:
        """Why the pilot is about to decide as it does for the lead of `snapshot`."""
        if self.reasoner is None:
            return None
        return self.reasoner.why(self._scene, snapshot, self._memory)

    def forced(self, snapshot: Snapshot) -> Array | None:
        """What the lead is forced to do next, (1, m); None where the person decides."""
        return None if self.pushes is None else self.pushes.next(snapshot)

    def decide(
        self, snapshot: Snapshot, interval: tuple[float, float], forced: Array | None = None
    ) -> Array:
        """The actions of all, for a step that acts on `interval` of the keys' time.

        What is `forced` is done instead of what the keys say.
        """
        scene = self._scene
        if self.pilot is not None:
            actions, self._memory = self.pilot.act(scene, snapshot, self._memory)
        else:
            theirs = None
            if self.others is not None:
                theirs, self._memory = self.others.act(scene, snapshot, self._memory)
            own = self.keys.read(*interval)
            actions = for_all(scene, snapshot, own if forced is None else forced, theirs)
        actions = sound(scene, actions)
        if self._signalled:
            own = of_lead(snapshot, actions).copy()
            own[:, list(self._signalled)] = list(self._signalled.values())
            own, self._signalled = scene.action.clip(own), {}
            actions = for_all(scene, snapshot, own, others=actions)
        return actions


def begun(pilot: Pilot, scene: Scene, seed: int) -> Memory:
    """The memory of `pilot` for that world; refuses a pilot that does not fit before we leave."""
    memory = pilot.begin(scene, [seed])
    pilot.act(scene, scene.worlds([seed]), memory)
    return memory
