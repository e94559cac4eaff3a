"""Stages against the clock: each runs on a thread of its own, with a store and policies at hand."""

from __future__ import annotations

import contextlib
import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError
from evastudio.live.approach import approach
from evastudio.live.correcting import Correcting
from evastudio.live.demonstrating import check_session
from evastudio.live.headless import make_scene
from evastudio.live.holding import Holding
from evastudio.live.inputs import Feel
from evastudio.live.looking_back import LookingBack
from evastudio.live.picture import Show
from evastudio.live.piloting import load_pilot
from evastudio.live.pulse import Pulse
from evastudio.live.series import Arrangement, Series
from evastudio.live.stage import Stage
from evastudio.live.status import Mode, Phase
from evastudio.live.tally import Tally
from evastudio.live.teller import STATUS_S, Teller
from evastudio.pilots.why import Reasoner
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot

CLOSE_S = 1.5
"""So long a stage that closes waits for its store; what is not saved then waits in a file."""


class LiveStage:
    """A stage on its own thread. Its methods may be called from any thread."""

    def __init__(
        self,
        name: str,
        workspace: Workspace,
        store: Store,
        scene: Scene,
        think: Callable[[Callable[[], None]], object],
        seed: int | None = None,
    ) -> None:
        """`seed` decides every world to come; drawn from the system where it is None. `think` does
        elsewhere what would hold the stage up, see `Coach`."""
        self.name = name
        self._workspace = workspace
        self._store = store
        self._seed = secrets.randbits(53) if seed is None else seed
        self._worlds = 0
        self._stage = Stage(scene, self._next_seed(), time.monotonic(), think)
        self._holding = Holding()
        self._series = Series()
        self._teller = Teller(name, self._stage, store, self._series)
        self._begun: tuple[str | None, bool] = (None, False)
        """The others of the latest take, and whether its character was pushed."""
        self.pulse = Pulse(f"stage-{name}", self._beat, self._failed)
        """What is asked of the stage from any thread goes through this."""
        self.looking_back = LookingBack(self, self._stage, workspace, store)
        self.correcting = Correcting(self, self._stage, workspace, store)
        self.pulse.start()

    @property
    def on_status(self) -> list[Callable[[dict[str, Any]], None]]:
        """Called on the stage's thread with what `status` gives; must not wait."""
        return self._teller.on_status

    @property
    def scene(self) -> Scene:
        """The scene it shows, with its present options."""
        return self._stage.scene

    @property
    def snapshot(self) -> Snapshot:
        """The world after the latest decision."""
        return self._stage.snapshot

    @property
    def phase(self) -> Phase:
        """What it does just now."""
        return self._stage.phase

    @property
    def tally(self) -> Tally:
        """Its decisions so far."""
        return self._stage.clock.tally

    @property
    def backlog(self) -> int:
        """Chunks of its takes that are not in the store yet."""
        recorder = self._stage.recorder
        return 0 if recorder is None else recorder.backlog

    # -- what a person does --------------------------------------------------------------------

    def choose_session(self, session: int | None) -> None:
        """Record into that session from now on. Raises NotFoundError, ConflictError."""
        if session is None:
            return
        record = self._store.session(session)
        check_session(record, self._stage.scene)
        present = self._stage.recorder
        if present is not None and present.problem is not None:
            raise ConflictError(
                f"The present session is not saved yet. {present.problem} Make room or unlock the "
                "store, then choose again."
            )
        recorder = Recorder(self._store, record.id, folders=self._workspace.unsaved)

        def change() -> Recorder | None:
            before, self._stage.recorder = self._stage.recorder, recorder
            if before is not None:
                self._series.halt()
                self._stage.stop(time.time())
                self._stage.coach = self._stage.coach.anew()
            return before

        before = self.pulse.call(change)
        if before is not None:
            before.close(time.time(), CLOSE_S)
        self.refresh()

    def demonstrate(
        self,
        options: Mapping[str, float] | None = None,
        others: str | None = None,
        seed: int | None = None,
        pushes: bool = False,
    ) -> None:
        """Begin a take in a new world, or that of `seed`; makes a session where none was chosen.

        `others` is the policy (or scripted pilot) of everybody else, who stand still without one.
        With `pushes` the character is forced off its way now and then; see `Pushes`.
        """
        self.begin_again()
        scene = make_scene(self._workspace, self._stage.scene.name, self._with(options))
        crowd = None if others is None else self.actor(others, scene)
        self.need_session()
        rng = np.random.default_rng([self._seed, self._worlds])
        forcing = self.correcting.pushes(scene, rng) if pushes else None

        def begin(seed: int | None = None) -> None:
            now, wall = time.monotonic(), time.time()
            self._stage.demonstrate(scene, self._seed_or(seed), now, wall, crowd, pushes=forcing)
            self._series.begun(begin)
            self._begun = others, pushes

        self.pulse.call(lambda: begin(seed))
        self.refresh()

    def arrange(self, arrangement: Arrangement) -> None:
        """How many takes are wanted, and whether the next begins by itself."""
        self.pulse.call(lambda: self._series.arrange(arrangement))
        self.refresh()

    def suit(self, feel: Feel) -> None:
        """See `Stage.suit`."""
        self.pulse.call(lambda: self._stage.suit(feel))

    def keep_pace(self, pace: float) -> None:
        """See `Stage.keep_pace`."""
        self.pulse.call(lambda: self._stage.keep_pace(pace, time.monotonic()))

    def begin_again(self) -> None:
        """Somebody asks for something new: what went wrong before is told no more."""
        self._teller.fault = None

    def need_session(self) -> None:
        """Make a session where none was chosen."""
        if self._stage.recorder is None:
            scene = self._stage.scene
            name = f"{scene.title} {self._store.count_sessions(scene.name) + 1}"
            made = self._store.create_session(scene, name, "person", time.time())
            self.choose_session(made)

    def play(
        self,
        pilot: str,
        options: Mapping[str, float] | None = None,
        seed: int | None = None,
        from_s: float = 0.0,
    ) -> None:
        """Let a policy (or a scripted pilot) act alone in a new world, or that of `seed`.

        Where it is to go on `from_s` seconds into that world, it is brought there as it was fitted,
        held still, and goes on without what was left out on this stage.
        """
        self.begin_again()
        scene = make_scene(self._workspace, self._stage.scene.name, self._with(options))
        actor = self.actor(pilot, scene)
        reasoner = Reasoner(actor)
        seed = self._seed_or(seed)
        steps = round(from_s / scene.dt_s)
        start = approach(scene, actor, seed, steps, reasoner) if steps else None
        self.correcting.forget_again(reasoner)

        def begin() -> None:
            self._series.halt()
            now, wall = time.monotonic(), time.time()
            self._stage.play(scene, actor, seed, now, wall, reasoner, start)

        self.pulse.call(begin)
        self.refresh()

    def restart(self, same: bool = False) -> None:
        """The same again in another world, or in the `same`: a take, or the policy once more.

        Where nothing is on, as after a take was thrown away, a take begins as the latest did.
        Raises ConflictError in a look back, out of which nothing is recorded by accident.
        """
        if self._stage.phase is Phase.REVIEWING:
            raise ConflictError("You are looking back. Fork from here, or leave first.")
        status = self.pulse.call(lambda: self._stage.status(time.monotonic()))
        seed = status.seed if same else None
        if status.policy is not None:
            self.play(status.policy, seed=seed)
        elif same and self._stage.run.forked_from is not None:
            self.looking_back.fork_from(*self._stage.run.forked_from, status.others)
        else:
            gone = status.mode is None
            others, pushes = self._begun if gone else (status.others, status.pushes)
            self.demonstrate(others=others, seed=seed, pushes=pushes)

    def pause(self) -> None:
        self.pulse.call(lambda: self._stage.pause(time.monotonic()))

    def resume(self) -> None:
        self.pulse.call(lambda: self._stage.resume(time.monotonic()))

    def signal(self, name: str, pointer: tuple[float, float, float] | None = None) -> None:
        """See `Stage.signal`."""
        self.pulse.call(lambda: self._stage.signal(name, pointer))

    def look_through(self, camera: str | None = None) -> None:
        """See `Stage.look_through`."""
        self.pulse.call(lambda: self._stage.look_through(camera))

    def lead_another(self) -> None:
        """See `Stage.lead_another`."""
        self.pulse.call(self._stage.lead_another)

    def stop(self) -> None:
        """End what runs, and begin nothing more."""
        self.pulse.call(self._series.halt)
        self.end_take()

    def end_take(self) -> None:
        """End what runs; where takes follow one another, the next comes after its rest."""
        self.pulse.call(lambda: self._stage.stop(time.time()))
        self.refresh()

    def discard(self) -> bool:
        done = self.pulse.call(lambda: self._stage.discard(time.time()))
        self.refresh()
        return done

    def undo(self) -> bool:
        done = self.pulse.call(self._stage.undo)
        self.refresh()
        return done

    def hold(
        self,
        codes: Sequence[str],
        age_s: float = 0.0,
        by: object = None,
        pushed: Mapping[str, float] | None = None,
    ) -> None:
        """`by` (a page, say) holds exactly these keys since `age_s` seconds ago; does not wait.

        `pushed` is how far sticks are, as in `HeldKeys.hold`. Where several hold keys or push
        sticks, all of them count. What plays gives way to whoever steers.
        """
        at = time.monotonic() - age_s

        def change() -> None:
            stage = self._stage
            self._holding.hold(by, codes, pushed or {})
            if stage.keys.steers(codes, pushed):
                stage.touch(time.monotonic(), time.time())
            if stage.phase is not Phase.RECORDING:
                stage.keys.center()
            holding = self._holding
            stage.keys.hold(holding.codes, stage.clock.world_time(at), holding.pushed)

        self.pulse.post(change)

    def nobody_there(self) -> None:
        """The last person went: release every key, and pause a demonstration; does not wait."""

        def change() -> None:
            self._holding.let_go()
            self._series.halt()
            self._stage.keys.center()
            if self._stage.mode in (Mode.DEMONSTRATE, Mode.CORRECT):
                self._stage.pause(time.monotonic())

        self.pulse.post(change)

    def watch(self, show: Show) -> None:
        """Call `show` on the stage's thread with what to draw, from now on until `unwatch`.

        It returns once the present frame was drawn. While nobody watches nothing is drawn.
        """

        def begin() -> None:
            self._stage.watch(show)
            self._advance()

        self.pulse.call(begin)

    def unwatch(self, show: Show) -> None:
        """Call `show` no more; does not wait."""
        self.pulse.post(lambda: self._stage.unwatch(show))

    def refresh(self) -> None:
        """Count the session anew once the recorder has written what it holds, then tell it."""
        self._teller.refresh(self.pulse)

    def status(self) -> dict[str, Any]:
        """The stage's `Status` and its session's totals, as JSON holds them."""
        return self.pulse.call(self._teller.status)

    def close(self) -> bool:
        """End the running take, write it, and stop the thread.

        False where the store refuses for too long: what it lacks then waits in a file.
        """
        self.pulse.close()
        recorder = self._stage.recorder
        if recorder is None:
            return True
        recorder.close(time.time(), CLOSE_S)
        return not recorder.left

    # -- the thread ----------------------------------------------------------------------------

    def _beat(self, called: bool) -> float:
        """Do what is due, and tell of it."""
        if called:  # a key may have come just before its decision: what it changes is told first
            self._safely(self._teller.tell_changes)
        recording = self._stage.phase is Phase.RECORDING
        due = min(self._advance(), time.monotonic() + STATUS_S)
        if recording and self._stage.phase is Phase.ENDED:
            self.refresh()
        self._safely(self._go_on)
        self._safely(self._teller.tell_changes)
        return due

    def _go_on(self) -> None:
        """Begin the next take where takes follow one another and it is due."""
        self._series.beat(self._stage.phase, self._teller.kept, time.monotonic())

    def _safely(self, work: Callable[[], None]) -> None:
        """Do `work`; a scene that fails while it is looked at does not end the thread either."""
        try:
            work()
        except Exception as error:
            self._failed(error)

    def _advance(self) -> float:
        """Advance the stage; a scene or pilot that fails ends the take, not the stage."""
        try:
            return self._stage.advance(time.monotonic(), time.time())
        except Exception as error:  # scenes and pilots are other people's code
            self._failed(error)
            return time.monotonic() + STATUS_S

    def _failed(self, error: Exception) -> None:
        """Keep the take, go back to ready, and tell why; once where it goes on failing."""
        self._teller.failed(error)
        self._series.halt()
        with contextlib.suppress(Exception):  # the scene may fail at its beginning too
            self._stage.stop(time.time())

    def actor(self, pilot: str, scene: Scene) -> Pilot:
        """A pilot by name that has decided once: a first decision may have to load compiled code,
        which is not for the stage's own thread."""
        actor = load_pilot(self._workspace, pilot, scene)
        actor.act(scene, scene.worlds([0]), actor.begin(scene, [0]))
        return actor

    def _seed_or(self, seed: int | None) -> int:
        return self._next_seed() if seed is None else seed

    def _next_seed(self) -> int:
        self._worlds += 1
        return world_seeds(self._seed, self._worlds)[-1]

    def _with(self, options: Mapping[str, float] | None) -> dict[str, float]:
        return {**self._stage.scene.values, **(options or {})}
