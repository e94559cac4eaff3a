"""An act: a run that is on a stage, who decides in it, and whether it moves."""

from __future__ import annotations

import math

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED
from evastudio.live.actors import Actors
from evastudio.live.coach import Coach
from evastudio.live.inputs import Feel
from evastudio.live.run import Run
from evastudio.live.status import Mode, Phase
from evastudio.pilots.why import Why
from evastudio.world.cast import of_lead
from evastudio.world.spaces import Array

COUNTDOWN_S = 3.0
FEW = 1000
"""Among so many characters what a pilot chose for the lead is told; among more it would cost a
second look at all of them."""
MOVING = (Phase.COUNTDOWN, Phase.RECORDING, Phase.PLAYING)


class Act:
    """What goes on in a run. `now` is a monotonic clock's, `wall` seconds since the epoch."""

    def __init__(self, run: Run, feel: Feel) -> None:
        """It stands, and nobody acts yet."""
        self.run = run
        self.actors = Actors(run.scene, feel)
        self.phase = Phase.READY
        self.mode: Mode | None = None
        self.chose: str | None = None
        """The symbol that what plays chose last, by name."""
        self.pushed = False
        """Whether the character is forced off its way just now."""
        self.countdown_ends = 0.0
        self._before_pause = Phase.READY
        self._paused_at = 0.0

    @property
    def running(self) -> bool:
        """Whether decisions fall."""
        return self.phase in (Phase.RECORDING, Phase.PLAYING)

    @property
    def meant(self) -> Phase:
        """The phase it is in, or would be if it were not paused."""
        return self._before_pause if self.phase is Phase.PAUSED else self.phase

    @property
    def plays(self) -> bool:
        """Whether somebody else than a person acts, or would if it were not paused."""
        return self.meant is Phase.PLAYING and self.actors.pilot is not None

    def count_down(self, now: float) -> None:
        """A person is to begin in a moment."""
        self.mode, self.phase = Mode.DEMONSTRATE, Phase.COUNTDOWN
        self.countdown_ends = now + COUNTDOWN_S

    def pause(self, now: float) -> bool:
        """Hold still; whether it moved."""
        moved = self.phase in MOVING
        if moved:
            self._before_pause, self.phase, self._paused_at = self.phase, Phase.PAUSED, now
            self.actors.keys.center()
        return moved

    def resume(self, now: float) -> bool:
        """Go on as before a pause; whether there was one."""
        paused = self.phase is Phase.PAUSED
        if paused:
            self.phase = self._before_pause
            self.countdown_ends += now - self._paused_at
        return paused

    def step(
        self,
        interval: tuple[float, float],
        recorder: Recorder | None,
        coach: Coach,
        wall: float,
    ) -> None:
        """The decision that acts on `interval` of the keys' time; `recorder` keeps a person's."""
        run, told = self.run, self.phase is Phase.PLAYING and self._few
        if told:
            run.reel.note(self.actors.why(run.after))
        if self.mode is Mode.CORRECT:
            run.reel.note_steered()
        forced = None if recorder is None else self._forced(recorder, wall)
        actions = self.actors.decide(run.after, interval, forced)
        if self.phase is Phase.RECORDING and recorder is not None and forced is None:
            recorder.add(run.states(), actions, run.after)
            coach.see(run, actions)
        if told:
            self.chose = run.symbol(of_lead(run.after, actions))
        run.step(actions)
        if run.outcome is not None:
            if recorder is not None:
                recorder.end(run.outcome, wall)
            self.phase = Phase.ENDED
            self.actors.keys.center()

    def decision(self, interval: tuple[float, float]) -> str | None:
        """See `Status.decision`; `interval` is what the next decision acts on."""
        if self.phase is Phase.PLAYING:
            return self.chose
        if self.phase is not Phase.RECORDING or not self.run.decides_symbols:
            return None
        return self.run.symbol(self.actors.keys.foresee(*interval))

    def why(self) -> Why | None:
        """What the decision that one looks at came from, or the latest one."""
        return self.run.reel.why(min(self.run.steps, self.run.reel.last - 1))

    def silent(self, why: Why | None) -> str | None:
        """See `Status.silent`."""
        if self.mode is not Mode.PLAY or self.actors.reasoner is None or not self.run.steps:
            return None
        if not self._few:
            return "There are too many characters to look at why one of them does what it does."
        return self.actors.reasoner.silence(why)

    @property
    def _few(self) -> bool:
        return math.prod(self.run.scene.characters) <= FEW

    def _forced(self, recorder: Recorder, wall: float) -> Array | None:
        """What the next decision is forced to be, in no take; None where a person decides."""
        if self.mode is not Mode.DEMONSTRATE:
            return None
        run, action = self.run, self.actors.forced(self.run.after)
        if action is not None and not self.pushed:
            recorder.end(None, wall)
            run.reel.key = None
        elif action is None and self.pushed:
            origin = run.reel.origin_at(run.steps)
            recorder.begin(run.scene, run.after, RECORDED, "person", wall, origin)
        self.pushed = action is not None
        return action
