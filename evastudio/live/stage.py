"""A stage: one live world with its clock, its pilot and its recorder, watched or not."""

from __future__ import annotations

import math
from collections.abc import Callable

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import RECORDED, Origin
from evastudio.errors import ConflictError, not_found
from evastudio.live.act import Act
from evastudio.live.actors import begun
from evastudio.live.canvas import Canvas
from evastudio.live.clock import Clock
from evastudio.live.coach import Coach, at_once
from evastudio.live.inputs import Feel, HeldKeys
from evastudio.live.picture import Show
from evastudio.live.pushing import Pushes
from evastudio.live.reel import Reel
from evastudio.live.review import Review
from evastudio.live.run import Run
from evastudio.live.sight import Pointer
from evastudio.live.standing import status_of
from evastudio.live.status import Mode, Phase, Status
from evastudio.pilots.why import Reasoner
from evastudio.world.bodies import Line
from evastudio.world.rollout import Memory, Pilot
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot


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
        self.recorder: Recorder | None = None
        self.clock = Clock(scene.dt_s, now)
        self.coach = Coach(scene.dt_s, think)
        self.look_back: Review | None = None
        """Where one looks back at, None where one does not."""
        self.rethought = 0
        """How often what plays was changed."""
        self._feel = Feel()
        self._canvas = Canvas(now)
        self._aside: Act | None = None
        """What was on the stage when somebody began to look back, and is again when they leave."""
        self.act = Act(Run.new(scene, seed), self._feel)

    @property
    def scene(self) -> Scene:
        """Of what is on the stage."""
        return self.act.run.scene

    @property
    def phase(self) -> Phase:
        return self.act.phase

    @property
    def mode(self) -> Mode | None:
        return self.act.mode

    @property
    def run(self) -> Run:
        """What is on the stage, or looked back at."""
        return self.act.run

    def watch(self, show: Show) -> None:
        """Call `show` with every frame, from the present one on."""
        self._canvas.watch(show)

    def unwatch(self, show: Show) -> None:
        """Call `show` no more."""
        self._canvas.unwatch(show)

    @property
    def keys(self) -> HeldKeys:
        """What the person holds."""
        return self.act.actors.keys

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
        self.act.actors.enter(others=others, memory=memory, pushes=pushes)
        self.act.count_down(now)

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
        self.act.actors.enter(pilot, memory=memory, reasoner=reasoner)
        self.act.mode, self.act.phase = Mode.PLAY, Phase.PLAYING
        self._start_clock(now)
        if start is not None:
            self.pause(now)

    def pause(self, now: float) -> None:
        """Hold still: during a countdown, a recording, playback or a look back."""
        if self.look_back is not None:
            self.look_back.roll(0.0, now)
        if self.act.pause(now) and self.recorder is not None:
            self.recorder.flush()

    def resume(self, now: float) -> None:
        """Go on after a pause, without a jump."""
        if self.look_back is not None:
            self.look_back.roll(1.0, now)
        if self.act.resume(now):
            self._start_clock(now)

    def keep_pace(self, pace: float, now: float) -> None:
        """See `Clock.keep_pace`."""
        self.clock.keep_pace(pace, now)

    def suit(self, feel: Feel) -> None:
        """Answer keys and sticks like that from now on."""
        self._feel = feel
        self.keys.suit(feel)

    def take_over(self, now: float, wall: float) -> None:
        """The person goes on from here instead of what plays, which still acts for the others, and
        every step is recorded. What was paused moves again."""
        if not self.act.plays:
            raise ConflictError("Nothing plays that you could take over from. Press Play first.")
        if self.recorder is None:
            raise ConflictError("There is no session to record into. Choose or make one first.")
        self.resume(now)
        self.act.actors.take_over()
        self.act.mode, self.act.phase = Mode.CORRECT, Phase.RECORDING
        origin = self.run.reel.origin_at(self.run.steps)
        self.recorder.begin(self.scene, self.run.after, RECORDED, "person", wall, origin)

    def touch(self, now: float, wall: float) -> None:
        """A person touches a control: what plays gives way, where it can be recorded."""
        if self.act.plays and self.recorder is not None:
            self.take_over(now, wall)

    def hand_back(self, wall: float) -> None:
        """What played before goes on from here; the correction is a take of its own."""
        actors = self.act.actors
        if self.mode is not Mode.CORRECT or actors.gave_way is None:
            raise ConflictError("You have not taken over from anything.")
        self.end_take(wall)
        actors.keys.center()
        actors.hand_back()
        self.act.mode, self.act.phase = Mode.PLAY, Phase.PLAYING

    def discard(self, wall: float) -> bool:
        """Throw away the running take, or the last one; whether there was one.

        In a countdown there is no take yet: it is only broken off.
        """
        if self.look_back is not None:
            self.leave()
        if self.act.meant is Phase.COUNTDOWN:
            self._rest()
            return False
        thrown = self.recorder is not None and self.recorder.discard(wall)
        if self.mode is Mode.DEMONSTRATE:
            self._rest()
        elif self.mode is Mode.CORRECT and self.phase is not Phase.ENDED:
            self.act.phase = Phase.RECORDING
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

    # -- looking back --------------------------------------------------------------------------

    def review(self, reel: Reel, at: float, now: float, seed: int | None = None) -> None:
        """Look back at a run, from step `at` on, in the world of `seed` where that is another.

        What is on the stage is paused, a running take too; `leave` goes back to it.
        """
        self.pause(now)
        aside = self._aside or self.act
        self._enter(Run(reel.scene, self.run.seed if seed is None else seed, reel))
        self.look_back, self._aside = Review(reel, at, now), aside
        self.act.mode, self.act.phase = Mode.REVIEW, Phase.REVIEWING
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
        assert self._aside is not None
        self.act, self.look_back, self._aside = self._aside, None, None
        self.keys.suit(self._feel)
        self._canvas.clear()
        self._canvas.soon()

    def sketch(self, lines: tuple[Line, ...]) -> None:
        """Draw `lines` over the moment that one looks at, for as long as one looks at it."""
        self._canvas.sketch(self.run.steps, lines)

    @property
    def present(self) -> Act:
        """What is on the stage, also while one looks back at another run."""
        return self._aside or self.act

    def here(self) -> tuple[Snapshot, Origin]:
        """The moment that one looks at, or the present one, and where it is from."""
        return self.run.after, self.run.reel.origin_at(self.run.steps)

    def rethink(self) -> None:
        """What plays has changed: tell of the decision that one looks at, or of the latest, what it
        would come from now."""
        present = self.present
        run = self.run if self.run.reel is present.run.reel else present.run
        step = min(run.steps, run.reel.last - 1)
        if run.reel.why(step) is not None:
            run.reel.note(present.actors.why(run.reel.moment(step)), step)
        self.rethought += 1
        self._canvas.soon()

    def _looking_back(self) -> Review:
        if self.look_back is None:
            raise ConflictError("There is nothing that is looked back at. Choose a take first.")
        return self.look_back

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
        if not self.act.running:
            raise ConflictError("Nothing moves at the moment. Demonstrate or play first.")
        found, place = known[name], None
        if found.place is not None:
            place = self._canvas.sight.pointed_at(pointer, self.scene, self.run.after)
        self.act.actors.give(found, place)

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
        if self.act.meant is Phase.RECORDING:
            raise ConflictError("A take is about one character. Stop it, then choose another.")
        self.run.lead_another()
        self._canvas.soon()

    # -- time ----------------------------------------------------------------------------------

    def advance(self, now: float, wall: float) -> float:
        """Do what is due at `now`; the time at which to call again, infinite where nothing is."""
        act = self.act
        if act.phase is Phase.COUNTDOWN and now >= act.countdown_ends:
            self._begin_take(wall)
            act.phase = Phase.RECORDING
            self._start_clock(act.countdown_ends)
        if self.look_back is not None and self.look_back.speed:
            self.look_back.advance(now)
            self._look()
        if act.running:
            for _ in self.clock.due_steps(now):
                self._canvas.decided(self.clock.due)
                act.step(self.clock.interval, self.recorder, self.coach, wall)
                if not act.running:
                    break
        if now >= self._canvas.due:
            self._canvas.draw(now, act, self.look_back, self.clock.share(now))
        return min(
            self._canvas.due,
            self.clock.due if act.running else math.inf,
            act.countdown_ends if act.phase is Phase.COUNTDOWN else math.inf,
        )

    def status(self, now: float) -> Status:
        return status_of(self, now)

    @property
    def snapshot(self) -> Snapshot:
        """The world after the latest decision."""
        return self.run.after

    @property
    def camera(self) -> str:
        """Name of the scene's camera that it is seen from."""
        return self._canvas.sight.name(self.scene, self.run.after)

    @property
    def cameras(self) -> tuple[str, ...]:
        """Where it can be seen from, by name."""
        return self._canvas.sight.names(self.scene, self.run.after)

    # -- inside --------------------------------------------------------------------------------

    def _enter(self, run: Run) -> None:
        self.act, self.look_back, self._aside = Act(run, self._feel), None, None
        self._canvas.clear()

    def _rest(self) -> None:
        self._enter(Run.new(self.scene, self.run.seed, self.run.lead or 0))

    def _start_clock(self, now: float) -> None:
        self.clock.start(now)
        self.run.stand()

    def _begin_take(self, wall: float) -> None:
        if self.recorder is not None:
            run = self.run
            self.recorder.begin(run.scene, run.after, run.take_seed, "person", wall, run.origin)
            run.reel.key = self.recorder.running_key
