"""A stage: one live world with its clock, its pilot and its recorder, watched or not."""

from __future__ import annotations

import math
from collections.abc import Callable

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.errors import ConflictError, InvalidInputError, not_found
from evastudio.live.actors import Actors, begun
from evastudio.live.canvas import Canvas
from evastudio.live.clock import Clock
from evastudio.live.coach import Coach, at_once
from evastudio.live.inputs import Feel, HeldKeys
from evastudio.live.picture import Show
from evastudio.live.pushing import Pushes
from evastudio.live.reel import Reel
from evastudio.live.review import Left, Review
from evastudio.live.run import Run
from evastudio.live.sight import Pointer
from evastudio.live.status import Mode, Phase, Status
from evastudio.pilots.why import Reasoner, Why
from evastudio.world.bodies import Line
from evastudio.world.cast import of_lead
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

COUNTDOWN_S = 3.0
PACES = (0.25, 1.0)
"""The slowest that a world's time goes, and the fastest, which is real time."""
FEW = 1000
"""Among so many characters what a pilot chose for the lead is told; among more it would cost a
second look at all of them."""


class Stage:
    """The state machine of a live world.

    It owns no thread and reads no clock: whoever drives it calls `advance(now)` at the time
    `advance` asked for, and calls everything else from that same thread. `now` is seconds of a
    monotonic clock, `wall` seconds since the epoch.
    """

    def __init__(
        self,
        scene: Scene,
        seed: int,
        now: float,
        think: Callable[[Callable[[], None]], object] = at_once,
    ) -> None:
        """`think` does what would hold the stage up, see `Coach`."""
        self.scene = scene
        self.recorder: Recorder | None = None
        self.phase = Phase.READY
        self.mode: Mode | None = None
        self.clock = Clock(scene.dt_s, now)
        self.coach = Coach(scene.dt_s, think)
        self._feel = Feel()
        self.run = Run.new(scene, seed)
        self._actors = Actors(scene)
        self._canvas = Canvas(now)
        self._chose: str | None = None
        self._review: Review | None = None
        self._left: Left | None = None
        self._countdown_ends = now
        self._before_pause = Phase.READY
        self._paused_at = now
        self.pushed = False
        """Whether the character is forced off its way just now."""
        self.rethought = 0
        """How often what plays was changed."""

    @property
    def on_frame(self) -> list[Show]:
        """Who is shown what is drawn."""
        return self._canvas.on_frame

    def watch(self, show: Show) -> None:
        """Call `show` with every frame, from the present one on."""
        self._canvas.on_frame.append(show)
        self._canvas.soon()

    @property
    def keys(self) -> HeldKeys:
        """What the person holds."""
        return self._actors.keys

    # -- commands ------------------------------------------------------------------------------

    def demonstrate(
        self,
        scene: Scene,
        seed: int,
        now: float,
        wall: float,
        others: Pilot | None = None,
        start: Snapshot | None = None,
        origin: Origin | None = None,
        pushes: Pushes | None = None,
    ) -> None:
        """A new world, a countdown, then every step is recorded. A running take is kept.

        Where many share a world, the keys are the lead's and `others` acts for the rest, who stand
        still where it is None. A take that goes on from a moment of another run begins at `start`,
        and `origin` says which that is. Where `pushes` force the character off its way now and
        then, what is forced is recorded in no take, and another take begins behind it.
        """
        if self.recorder is None:
            raise ConflictError("There is no session to record into. Choose or make one first.")
        memory = {} if others is None else begun(others, scene, seed)
        self.end_take(wall)
        if start is None or origin is None:
            run = Run.new(scene, seed, self.run.lead or 0)
        else:
            run = Run.fork(scene, seed, start, origin)
        self._enter(run)
        self._actors.enter(others=others, memory=memory, pushes=pushes)
        self.mode, self.phase = Mode.DEMONSTRATE, Phase.COUNTDOWN
        self._countdown_ends = now + COUNTDOWN_S

    def play(
        self,
        scene: Scene,
        pilot: Pilot,
        seed: int,
        now: float,
        wall: float,
        reasoner: Reasoner | None = None,
        start: tuple[Run, Memory] | None = None,
    ) -> None:
        """`pilot` acts alone in a new world; nothing is recorded. `reasoner` tells why it does.

        Where it came to a moment of that world already, as `approach` gives it, it goes on from
        there, once it is told to.
        """
        memory = begun(pilot, scene, seed) if start is None else start[1]
        self.end_take(wall)
        self._enter(
            Run.new(scene, seed, self.run.lead or 0, pilot.name) if start is None else start[0]
        )
        self._actors.enter(pilot, memory=memory, reasoner=reasoner)
        self.mode, self.phase = Mode.PLAY, Phase.PLAYING
        self._start_clock(now)
        if start is not None:
            self.pause(now)

    def pause(self, now: float) -> None:
        """Hold still: during a countdown, a recording, playback or a look back."""
        if self._review is not None:
            self._review.roll(0.0, now)
        if self.phase in (Phase.COUNTDOWN, Phase.RECORDING, Phase.PLAYING):
            self._before_pause, self.phase, self._paused_at = self.phase, Phase.PAUSED, now
            self.keys.center()
            if self.recorder is not None:
                self.recorder.flush()

    def resume(self, now: float) -> None:
        """Go on after a pause, without a jump."""
        if self._review is not None:
            self._review.roll(1.0, now)
        if self.phase is Phase.PAUSED:
            self.phase = self._before_pause
            self._countdown_ends += now - self._paused_at
            self._start_clock(now)

    def keep_pace(self, pace: float, now: float) -> None:
        """Let the world's time go `pace` times as fast; what is recorded is in its own time.

        Raises InvalidInputError outside of `PACES`.
        """
        if not PACES[0] <= pace <= PACES[1]:
            raise InvalidInputError(
                f"The pace is {pace:g}; it must be from {PACES[0]:g} to {PACES[1]:g}."
            )
        self.clock.keep_pace(pace, now)

    def suit(self, feel: Feel) -> None:
        """Answer keys and sticks like that from now on."""
        self._feel = feel
        self.keys.suit(feel)

    def take_over(self, now: float, wall: float) -> None:
        """The person goes on from here instead of what plays, and every step is recorded.

        What plays goes on acting for the others, where there are any. What was paused moves again.
        """
        if not self.plays:
            raise ConflictError("Nothing plays that you could take over from. Press Play first.")
        if self.recorder is None:
            raise ConflictError("There is no session to record into. Choose or make one first.")
        self.resume(now)
        self._actors.take_over()
        self.mode, self.phase = Mode.CORRECT, Phase.RECORDING
        origin = self.run.reel.origin_at(self.run.steps)
        self.recorder.begin(self.scene, self.run.after, RECORDED, "person", wall, origin)

    def touch(self, now: float, wall: float) -> None:
        """A person touches a control: what plays gives way, where it can be recorded."""
        if self.plays and self.recorder is not None:
            self.take_over(now, wall)

    def hand_back(self, wall: float) -> None:
        """What played before goes on from here; the correction is a take of its own."""
        if self.mode is not Mode.CORRECT or self._actors.gave_way is None:
            raise ConflictError("You have not taken over from anything.")
        self.end_take(wall)
        self.keys.center()
        self._actors.hand_back()
        self.mode, self.phase = Mode.PLAY, Phase.PLAYING

    # -- looking back --------------------------------------------------------------------------

    def review(self, reel: Reel, at: float, now: float, seed: int | None = None) -> None:
        """Look back at a run, from step `at` on, in the world of `seed` where that is another.

        What is on the stage is paused, a running take too; `leave` goes back to it.
        """
        self.pause(now)
        left = self._left or Left(self.run, self._actors, self.mode, self.phase, self._before_pause)
        self._enter(Run(reel.scene, self.run.seed if seed is None else seed, reel))
        self._review, self._left = Review(reel, at, now), left
        self.mode, self.phase = Mode.REVIEW, Phase.REVIEWING
        self._look()

    def seek(self, at: float, now: float) -> None:
        """Look at step `at` of the run, or between two. Raises ConflictError in no look back."""
        self._looking_back().seek(at, now)
        self._look()

    def roll(self, speed: float, now: float) -> None:
        """See `Review.roll`. Raises ConflictError in no look back."""
        self._looking_back().roll(speed, now)

    def leave(self) -> None:
        """Back to what was on the stage before one looked back, held still where it was moving.

        Raises ConflictError in no look back.
        """
        self._looking_back()
        left = self._left
        assert left is not None
        self._enter(left.run)
        self._actors = left.actors
        self.keys.suit(self._feel)
        self.mode, self.phase, self._before_pause = left.mode, left.phase, left.before_pause
        self._canvas.soon()

    def sketch(self, lines: tuple[Line, ...]) -> None:
        """Draw `lines` over the moment that one looks at, for as long as one looks at it."""
        self._canvas.sketch(self.run.steps, lines)

    @property
    def present(self) -> Run:
        """The run that is on the stage, also while one looks back at another."""
        return self.run if self._left is None else self._left.run

    def here(self) -> tuple[Snapshot, Origin]:
        """The moment that one looks at, or the present one, and where it is from."""
        return self.run.after, self.run.reel.origin_at(self.run.steps)

    @property
    def reasoner(self) -> Reasoner | None:
        """Of what plays, or gave way to a person, or was left for a look back."""
        return (self._actors if self._left is None else self._left.actors).reasoner

    def why(self) -> Why | None:
        """What the decision that one looks at came from, or the latest one."""
        return self.run.reel.why(min(self.run.steps, self.run.reel.last - 1))

    def rethink(self) -> None:
        """What plays has changed: tell of the decision that one looks at, or of the latest, what it
        would come from now."""
        run = self.run if self.run.reel is self.present.reel else self.present
        actors = self._actors if self._left is None else self._left.actors
        step = min(run.steps, run.reel.last - 1)
        if run.reel.why(step) is not None:
            run.reel.note(actors.why(run.reel.moment(step)), step)
        self.rethought += 1
        self._canvas.soon()

    @property
    def plays(self) -> bool:
        """Whether somebody else than a person acts, or would if it were not paused."""
        moving = self._before_pause if self.phase is Phase.PAUSED else self.phase
        return moving is Phase.PLAYING and self._actors.pilot is not None

    def _looking_back(self) -> Review:
        if self._review is None:
            raise ConflictError("There is nothing that is looked back at. Choose a take first.")
        return self._review

    def _look(self) -> None:
        self.run.look(self._looking_back().step)
        self._canvas.soon()

    # -- whom and from where -------------------------------------------------------------------

    def signal(self, name: str, pointer: Pointer | None = None) -> None:
        """Do what the scene's signal of that name does, with the next decision.

        `pointer` is where in the view it is meant: across and up, each from -1 to 1, and the
        view's width over its height; the middle of the view where it is None. Raises NotFoundError
        for a signal that the scene has not, ConflictError while nothing moves, InvalidInputError
        where the pointer is not at the ground.
        """
        known = {signal.name: signal for signal in self.scene.signals}
        if name not in known:
            raise not_found("signal", name, known, f"of scene {self.scene.name!r}")
        if not self._running:
            raise ConflictError("Nothing moves at the moment. Demonstrate or play first.")
        found, place = known[name], None
        if found.place is not None:
            place = self._canvas.sight.pointed_at(pointer, self.scene, self.run.after)
        self._actors.give(found, place)

    def look_through(self, camera: str | None = None) -> None:
        """See the world from that camera from now on, or from the one after the present one.

        Raises NotFoundError.
        """
        self._canvas.sight.choose(camera, self.scene, self.run.after)
        self._canvas.soon()

    def lead_another(self) -> None:
        """Guide, and follow with the camera, the next of many characters.

        Raises ConflictError during a take, which is about one of them, or where there is one only.
        """
        if not self.scene.characters:
            raise ConflictError("There is one character only.")
        if self._recording:
            raise ConflictError("A take is about one character. Stop it, then choose another.")
        self.run.led_by(((self.run.lead or 0) + 1) % self.scene.characters[0])
        self._canvas.soon()

    def discard(self, wall: float) -> bool:
        """Throw away the running take, or the last one; whether there was one.

        In a countdown there is no take yet: it is only broken off.
        """
        if self._review is not None:
            self.leave()
        if self._counting_down:
            self._rest()
            return False
        thrown = self.recorder is not None and self.recorder.discard(wall)
        if self.mode is Mode.DEMONSTRATE:
            self._rest()
        elif self.mode is Mode.CORRECT and self.phase is not Phase.ENDED:
            self.phase = Phase.RECORDING
            self.hand_back(wall)
        return thrown

    def undo(self) -> bool:
        """Bring the take back that was thrown away last; whether there was one."""
        return self.recorder is not None and self.recorder.undo()

    def stop(self, wall: float) -> None:
        """Back to ready. A running take is kept as it is."""
        self.end_take(wall)
        self._rest()

    def end_take(self, wall: float) -> None:
        """End the running take, if any, as one that was broken off."""
        if self.recorder is not None:
            self.recorder.end(None, wall)

    # -- time ----------------------------------------------------------------------------------

    def advance(self, now: float, wall: float) -> float:
        """Do what is due at `now`; the time at which to call again, infinite where nothing is."""
        if self.phase is Phase.COUNTDOWN and now >= self._countdown_ends:
            self._begin_take(wall)
            self.phase = Phase.RECORDING
            self._start_clock(self._countdown_ends)
        if self._review is not None and self._review.speed:
            self._review.advance(now)
            self._look()
        if self._running:
            for _ in self.clock.due_steps(now):
                self._canvas.decided(self.clock.due)
                self._step(wall)
                if not self._running:
                    break
        if now >= self._canvas.due:
            self._draw(now)
        return min(
            self._canvas.due,
            self.clock.due if self._running else math.inf,
            self._countdown_ends if self.phase is Phase.COUNTDOWN else math.inf,
        )

    def status(self, now: float) -> Status:
        counting, review = self.phase is Phase.COUNTDOWN, self._review
        run, outcome, why = self.run, self.run.outcome, self.why()
        return Status(
            phase=self.phase,
            mode=self.mode,
            countdown_s=max(0.0, self._countdown_ends - now) if counting else 0.0,
            pairs=self.recorder.pairs if self.recorder is not None else 0,
            seconds=run.steps * self.scene.dt_s,
            progress=float(self.scene.progress(run.after)[0]),
            outcome=outcome,
            success=None if outcome is None else outcome in self.scene.successes,
            can_undo=self.recorder is not None and self.recorder.can_undo,
            late_steps=self.clock.late_steps,
            steps=self.clock.steps,
            pace=self.clock.pace,
            position_s=None if review is None else review.seconds,
            length_s=run.reel.last * self.scene.dt_s,
            speed=0.0 if review is None else review.speed,
            take=None if review is None else run.reel.origin.take,
            drift_s=self.clock.drift_s,
            policy=self._actors.playing,
            others=None if self._actors.others is None else self._actors.others.name,
            familiarity=None if why is None else why.familiarity,
            silent=self._silent(why),
            forgotten=self.rethought,
            by_hand=run.reel.steered(min(run.steps, run.reel.last - 1)),
            pushed=self.pushed,
            pushes=self.pushes,
            decision=self.decision,
            decides_s=None if self.decision is None else max(0.0, self.clock.due - now),
            lead=run.lead,
            camera=self.camera,
            cameras=self._canvas.sight.names(self.scene, run.after),
            seed=run.seed,
            forked=run.origin is not None,
            options=dict(self.scene.values),
            coach=self.coach.advice,
            problem=None if self.recorder is None else self.recorder.problem,
        )

    @property
    def snapshot(self) -> Snapshot:
        """The world after the latest decision."""
        return self.run.after

    @property
    def looked_at(self) -> tuple[int | None, float, float] | None:
        """Take, position and speed of the look back, None where there is none."""
        review, take = self._review, self.run.reel.origin.take
        return None if review is None else (take, review.position, review.speed)

    @property
    def forked_from(self) -> tuple[Snapshot, Origin] | None:
        """Where the present run goes on from, None where it began in a world of its own."""
        run = self.run
        return None if run.origin is None else (run.reel.moment(0), run.origin)

    @property
    def pushes(self) -> bool:
        """Whether the character is forced off its way now and then."""
        return self._actors.pushes is not None

    @property
    def camera(self) -> str:
        """Name of the scene's camera that it is seen from."""
        return self._canvas.sight.name(self.scene, self.run.after)

    @property
    def decision(self) -> str | None:
        """See `Status.decision`."""
        if self.phase is Phase.PLAYING:
            return self._chose
        if self.phase is not Phase.RECORDING or not self.run.decides_symbols:
            return None
        return self.run.symbol(self.keys.foresee(*self.clock.interval))

    # -- inside --------------------------------------------------------------------------------

    @property
    def _counting_down(self) -> bool:
        paused = self.phase is Phase.PAUSED and self._before_pause is Phase.COUNTDOWN
        return paused or self.phase is Phase.COUNTDOWN

    @property
    def _running(self) -> bool:
        return self.phase in (Phase.RECORDING, Phase.PLAYING)

    @property
    def _recording(self) -> bool:
        paused = self.phase is Phase.PAUSED and self._before_pause is Phase.RECORDING
        return paused or self.phase is Phase.RECORDING

    def _enter(self, run: Run) -> None:
        self.run, self.scene, self._review, self._left = run, run.scene, None, None
        self._actors = Actors(run.scene, self._feel)
        self._canvas.clear()
        self._chose = None
        self.pushed = False

    def _rest(self) -> None:
        self.phase, self.mode = Phase.READY, None
        self._enter(Run.new(self.scene, self.run.seed, self.run.lead or 0))

    def _start_clock(self, now: float) -> None:
        self.clock.start(now)
        self.run.stand()

    def _begin_take(self, wall: float) -> None:
        if self.recorder is not None:
            run = self.run
            self.recorder.begin(run.scene, run.after, run.take_seed, "person", wall, run.origin)
            run.reel.key = self.recorder.running_key

    def _step(self, wall: float) -> None:
        run = self.run
        told = self.phase is Phase.PLAYING and math.prod(self.scene.characters) <= FEW
        if told:
            run.reel.note(self._actors.why(run.after))
        if self.mode is Mode.CORRECT:
            run.reel.note_steered()
        forced = self._forced(wall)
        actions = self._actors.decide(run.after, self.clock.interval, forced)
        if self.phase is Phase.RECORDING and self.recorder is not None and forced is None:
            self.recorder.add(run.states(), actions, run.after)
            self.coach.see(run, actions)
        if told:
            self._chose = run.symbol(of_lead(run.after, actions))
        run.step(actions)
        if run.outcome is not None:
            if self.recorder is not None:
                self.recorder.end(run.outcome, wall)
            self.phase = Phase.ENDED
            self.keys.center()

    def _forced(self, wall: float) -> Array | None:
        """What the next decision is forced to be, in no take; None where a person decides."""
        if self.mode is not Mode.DEMONSTRATE or self.recorder is None:
            return None
        run, action = self.run, self._actors.forced(self.run.after)
        if action is not None and not self.pushed:
            self.recorder.end(None, wall)
            run.reel.key = None
        elif action is None and self.pushed:
            origin = run.reel.origin_at(run.steps)
            self.recorder.begin(run.scene, run.after, RECORDED, "person", wall, origin)
        self.pushed = action is not None
        return action

    def _draw(self, now: float) -> None:
        run = self.run
        snapshot = run.after
        if self._running:
            snapshot = self.scene.interpolate(run.before, run.after, self.clock.share(now))
        elif self._review is not None:
            snapshot = self._review.picture
        lines: tuple[Line, ...] = ()
        if self._review is not None or self.mode in (Mode.PLAY, Mode.CORRECT):
            still = self.phase is Phase.PAUSED and self.mode is Mode.PLAY
            lines = self._canvas.lines(run, reasons=still or self._review is not None)
        self._canvas.draw(now, run, snapshot, lines)

    def _silent(self, why: Why | None) -> str | None:
        actors, run = self._actors, self.run
        if self.mode is not Mode.PLAY or actors.reasoner is None or not run.steps:
            return None
        if math.prod(self.scene.characters) > FEW:
            return "There are too many characters to look at why one of them does what it does."
        return actors.reasoner.silence(why)
