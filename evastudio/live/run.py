"""A run of a world on a stage: how it stands now, and what happened in it so far."""

from __future__ import annotations

from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.errors import ConflictError
from evastudio.live.reel import Reel
from evastudio.world.cast import LEAD, led_by, of_lead
from evastudio.world.scene import Percept, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Symbols


class Run:
    """A world from its beginning, or from a moment of another run, to now."""

    def __init__(self, scene: Scene, seed: int, reel: Reel, origin: Origin | None = None) -> None:
        """At the last moment of `reel`; `origin` is where it goes on from, if anywhere."""
        self.scene = scene
        self.seed = seed
        """Of the world, also where it goes on from a moment of another run in it."""
        self.reel = reel
        self.origin = origin
        self.steps = reel.last
        """Decisions so far."""
        self.after = self.before = reel.moment(reel.last)
        """The world after the latest decision and before it; drawing goes from one to the other."""
        self._percept: Percept | None = None
        self._judged: tuple[Snapshot | None, int] = (None, 0)

    @classmethod
    def new(cls, scene: Scene, seed: int, lead: int = 0, policy: str | None = None) -> Run:
        """In the world of `seed`, where the character `lead` leads; `policy` is what plays."""
        if scene.characters:
            lead %= scene.characters[0]
        reel = Reel(scene, Origin(0, policy=policy, seed=seed))
        reel.add(led_by(scene.worlds([seed]), lead))
        return cls(scene, seed, reel)

    @classmethod
    def fork(cls, scene: Scene, seed: int, start: Snapshot, origin: Origin) -> Run:
        """From the moment `start` of another run on, which `origin` names."""
        reel = Reel(scene, origin)
        reel.add(start)
        return cls(scene, seed, reel, origin)

    @property
    def forked_from(self) -> tuple[Snapshot, Origin] | None:
        """Where it goes on from, None where it began in a world of its own."""
        return None if self.origin is None else (self.reel.moment(0), self.origin)

    @property
    def take_seed(self) -> int:
        """What a take of this run has for a seed."""
        return self.seed if self.origin is None else RECORDED

    @property
    def lead(self) -> int | None:
        """Which of many characters leads."""
        lead = self.after.moving.get(LEAD)
        return None if lead is None else int(lead[0])

    def lead_another(self) -> None:
        """Let the next of many characters lead. Raises ConflictError where there is one only."""
        if not self.scene.characters:
            raise ConflictError("There is one character only.")
        character = ((self.lead or 0) + 1) % self.scene.characters[0]
        self.before = led_by(self.before, character)
        self.after = led_by(self.after, character)
        self._percept = None

    def percept(self) -> Percept:
        """What everybody perceives now under the scene's first perception."""
        if self._percept is None:
            self._percept = self.scene.perception().perceive(self.after)
        return self._percept

    def states(self) -> Array:
        """What the lead perceives of it, (1, n)."""
        return of_lead(self.after, self.percept().states)

    @property
    def outcome(self) -> str | None:
        """What has become of the world, None while it runs; found once for each moment."""
        moment, code = self._judged
        if moment is not self.after:
            code = int(self.scene.outcome(self.after)[0])
            self._judged = (self.after, code)
        return self.scene.outcomes[code] if code else None

    @property
    def decides_symbols(self) -> bool:
        return isinstance(self.scene.chosen(self.scene.perception()), Symbols)

    def symbol(self, actions: Array) -> str | None:
        """What `actions` (1, m) of the lead come to, by name; None where that is no symbol."""
        view = self.scene.perception()
        chosen = self.scene.chosen(view)
        if not isinstance(chosen, Symbols) or not view.applies(self.after)[0]:
            return None
        frame = of_lead(self.after, self.percept().frame)
        code = view.to_own(frame, self.scene.action.clip(actions))
        return chosen.names[int(code[0, 0])]

    def step(self, actions: Array) -> None:
        """One decision on."""
        self.before, self.after = self.after, self.scene.step(self.after, actions)
        self._percept = None
        self.steps += 1
        self.reel.add(self.after)

    def stand(self) -> None:
        """Nothing is under way: what is drawn is the world as it stands."""
        self.before = self.after

    def look(self, step: int) -> None:
        """Stand as it did at that step."""
        self.steps = step
        self.before = self.after = self.reel.moment(step)
        self._percept = None
