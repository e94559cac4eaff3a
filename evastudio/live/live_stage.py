"""Stages against the clock: each runs on a thread of its own, with a store and policies at hand."""

from __future__ import annotations

import contextlib
import copy
import logging
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

from evastudio.demonstrations.by_hand import mark_by_hand
from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.trimming import keep_last
from evastudio.errors import ConflictError, StudioError
from evastudio.learning.neighbor_learner import NeighborLearner
from evastudio.live.demonstrating import check_session
from evastudio.live.headless import make_scene
from evastudio.live.picture import Picture, Show
from evastudio.live.piloting import load_pilot
from evastudio.live.reel import Reel
from evastudio.live.stage import Stage
from evastudio.live.status import Mode, Phase, Status
from evastudio.live.tally import Tally
from evastudio.pilots.why import Reasoner, Why
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot

logger = logging.getLogger(__name__)

T = TypeVar("T")

PATIENCE_S = 30.0
"""What is asked of a stage is done within this time, or has failed."""
CLOSE_S = 1.5
"""So long a stage that closes waits for its store; what is not saved then waits in a file."""
STATUS_S = 0.125
"""While a stage moves its status is told this often, and at once when it changes phase; what others
change, as a store that takes pairs again, is seen within this time."""


@dataclass(frozen=True)
class Totals:
    """What the store holds of the stage's session."""

    session: Mapping[str, Any] | None
    takes_kept: int
    pairs_kept: int


class LiveStage:
    """A stage on its own thread. Its methods may be called from any thread."""

    def __init__(
        self, name: str, workspace: Workspace, store: Store, scene: Scene, seed: int | None = None
    ) -> None:
        """`seed` decides every world to come; drawn from the system where it is None."""
        self.name = name
        self.on_status: list[Callable[[dict[str, Any]], None]] = []
        """Called on the stage's thread; must not wait."""
        self._workspace = workspace
        self._store = store
        self._seed = secrets.randbits(53) if seed is None else seed
        self._worlds = 0
        self._totals = Totals(None, 0, 0)
        self._stage = Stage(scene, self._next_seed(), time.monotonic())
        self._calls: deque[Callable[[], None]] = deque()
        self._wake = threading.Condition()
        self._closing = False
        self._told_at = 0.0
        self._told: tuple[Any, ...] = ()
        self._fault: str | None = None
        self._undrawn = False
        self._watching: dict[Show, Show] = {}
        self._held: dict[object, frozenset[str]] = {}
        self._thread = threading.Thread(target=self._run, name=f"stage-{name}", daemon=True)
        self._thread.start()

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
                self._stage.stop(time.time())
            return before

        before = self.call(change)
        if before is not None:
            before.close(time.time(), CLOSE_S)
        self.refresh()

    def demonstrate(
        self,
        options: Mapping[str, float] | None = None,
        others: str | None = None,
        seed: int | None = None,
    ) -> None:
        """Begin a take in a new world, or that of `seed`; makes a session where none was chosen.

        `others` is the policy (or scripted pilot) of everybody else, who stand still without one.
        """
        self._fault = None
        scene = make_scene(self._workspace, self._stage.scene.name, self._with(options))
        crowd = None if others is None else self._actor(others, scene)
        self._need_session()
        self.call(
            lambda: self._stage.demonstrate(
                scene, self._seed_or(seed), time.monotonic(), time.time(), crowd
            )
        )
        self.refresh()

    def fork(self, others: str | None = None) -> None:
        """Begin a take at the moment that is looked at, or at the present one."""
        self._fork(*self.call(self._stage.here), others)

    def _fork(self, start: Snapshot, origin: Origin, others: str | None) -> None:
        self._fault = None
        scene = self._stage.scene
        crowd = None if others is None else self._actor(others, scene)
        self._need_session()
        self.call(
            lambda: self._stage.demonstrate(
                scene, self._stage.run.seed, time.monotonic(), time.time(), crowd, start, origin
            )
        )
        self.refresh()

    def take_over(self) -> None:
        """Go on by hand from what plays; see `Stage.take_over`."""
        self._need_session()
        self.call(lambda: self._stage.take_over(time.monotonic(), time.time()))

    def hand_back(self) -> None:
        """See `Stage.hand_back`."""
        self.call(lambda: self._stage.hand_back(time.time()))
        self.refresh()

    def keep_last(self, seconds: float) -> None:
        """End the running take, or take the last one, and keep its last `seconds` only.

        Raises ConflictError where there is none, InvalidInputError where the take is shorter.
        """
        self.stop()
        recorder = self._stage.recorder
        key = None if recorder is None else recorder.last_key
        if recorder is None or key is None:
            raise ConflictError("There is no take to keep the end of. Demonstrate first.")
        written = threading.Event()
        recorder.settle(written.set)
        written.wait(PATIENCE_S)
        keep_last(self._store, self._store.find_take(key).id, seconds, time.time())
        self.refresh()

    def review(self, take: int | None = None, at_s: float = 0.0) -> None:
        """Look back at a take, or at the run that is on the stage."""
        self._fault = None
        if take is None:
            reel = self._stage.run.reel
        else:
            record = self._store.take(take)
            session = self._store.session(record.session)
            if session.scene != self._stage.scene.name:
                raise ConflictError(
                    f"Take {record.number} of {session.name!r} is of scene {session.scene!r}; this "
                    f"stage shows {self._stage.scene.name!r}."
                )
            scene = make_scene(self._workspace, session.scene, record.options)
            reel = Reel.of_take(scene, record, self._store.load_take(take))
        self.call(
            lambda: self._stage.review(reel, at_s / reel.scene.dt_s, time.monotonic(), time.time())
        )
        self.refresh()

    def seek(self, at_s: float) -> None:
        """Look at that second of the run."""
        self.call(lambda: self._stage.seek(at_s / self._stage.scene.dt_s, time.monotonic()))

    def roll(self, speed: float) -> None:
        """See `Review.roll`."""
        self.call(lambda: self._stage.roll(speed, time.monotonic()))

    def why(self) -> Why | None:
        """See `Stage.why`."""
        return self.call(self._stage.why)

    def forget(self, take: int, step: int) -> None:
        """Leave a demonstrated moment out: what plays decides without it at once, and so does
        every policy fitted to its session from now on.

        Raises ConflictError where nothing plays that could forget, NotFoundError where it has not
        learned from that moment.
        """
        reasoner = self._stage.reasoner
        if reasoner is None:
            raise ConflictError("Nothing plays that could forget. Press Play first.")
        pilot, pairs = reasoner.holder(take, step)
        policy = pilot.policy
        if isinstance(policy.learner, NeighborLearner):
            self.call(lambda: setattr(pilot, "policy", policy.without(pairs)))
        else:  # fitted anew, which the stage does not wait for
            pilot.policy = copy.deepcopy(policy).without(pairs)
        if policy.extra.get("store") == self._store.identity:
            mark_by_hand(self._store, take, step, True, time.time())
        self.refresh()

    def keep_pace(self, pace: float) -> None:
        """See `Stage.keep_pace`."""
        self.call(lambda: self._stage.keep_pace(pace, time.monotonic()))

    def _need_session(self) -> None:
        """Make a session where none was chosen."""
        if self._stage.recorder is None:
            scene = self._stage.scene
            name = f"{scene.title} {self._store.count_sessions(scene.name) + 1}"
            made = self._store.create_session(scene, name, "person", time.time())
            self.choose_session(made)

    def play(
        self, pilot: str, options: Mapping[str, float] | None = None, seed: int | None = None
    ) -> None:
        """Let a policy (or a scripted pilot) act alone in a new world, or that of `seed`."""
        self._fault = None
        scene = make_scene(self._workspace, self._stage.scene.name, self._with(options))
        actor = self._actor(pilot, scene)
        reasoner = Reasoner(actor)
        self.call(
            lambda: self._stage.play(
                scene, actor, self._seed_or(seed), time.monotonic(), time.time(), reasoner
            )
        )
        self.refresh()

    def restart(self, same: bool = False) -> None:
        """The same again in another world, or in the `same`: a take, or the policy once more."""
        status = self.call(lambda: self._stage.status(time.monotonic()))
        seed = status.seed if same else None
        if status.policy is not None:
            self.play(status.policy, seed=seed)
        elif same and self._stage.forked_from is not None:
            self._fork(*self._stage.forked_from, status.others)
        else:
            self.demonstrate(others=status.others, seed=seed)

    def pause(self) -> None:
        self.call(lambda: self._stage.pause(time.monotonic()))

    def resume(self) -> None:
        self.call(lambda: self._stage.resume(time.monotonic()))

    def signal(self, name: str, pointer: tuple[float, float, float] | None = None) -> None:
        """See `Stage.signal`."""
        self.call(lambda: self._stage.signal(name, pointer))

    def look_through(self, camera: str | None = None) -> None:
        """See `Stage.look_through`."""
        self.call(lambda: self._stage.look_through(camera))

    def lead_another(self) -> None:
        """See `Stage.lead_another`."""
        self.call(self._stage.lead_another)

    def stop(self) -> None:
        self.call(lambda: self._stage.stop(time.time()))
        self.refresh()

    def discard(self) -> bool:
        done = self.call(lambda: self._stage.discard(time.time()))
        self.refresh()
        return done

    def undo(self) -> bool:
        done = self.call(self._stage.undo)
        self.refresh()
        return done

    def hold(self, codes: Sequence[str], age_s: float = 0.0, by: object = None) -> None:
        """`by` (a page, say) holds exactly these keys since `age_s` seconds ago; does not wait.

        Where several hold keys, all of them count.
        """
        at = time.monotonic() - age_s

        def change() -> None:
            stage = self._stage
            self._held.pop(by, None)
            if codes:
                self._held[by] = frozenset(codes)
            if stage.phase is not Phase.RECORDING:
                stage.keys.center()
            held = frozenset().union(*self._held.values())
            stage.keys.hold(held, stage.clock.world_time(at))

        self._post(change)

    def nobody_there(self) -> None:
        """The last person went: release every key, and pause a demonstration; does not wait."""

        def change() -> None:
            self._held.clear()
            self._stage.keys.center()
            if self._stage.mode in (Mode.DEMONSTRATE, Mode.CORRECT):
                self._stage.pause(time.monotonic())

        self._post(change)

    def watch(self, show: Show) -> None:
        """Call `show` on the stage's thread with what to draw, from now on until `unwatch`.

        It returns once the present frame was drawn. A frame that cannot be drawn is dropped:
        nobody's take ends for it. While nobody watches nothing is drawn.
        """

        def drawn(picture: Picture) -> None:
            try:
                show(picture)
            except Exception:  # scenes say what to draw, and scenes are other people's code
                if not self._undrawn:
                    logger.exception("Stage %s cannot be drawn", self.name)
                self._undrawn = True

        def begin() -> None:
            self._watching[show] = drawn
            self._stage.on_frame.append(drawn)
            self._advance()

        self.call(begin)

    def unwatch(self, show: Show) -> None:
        """Call `show` no more; does not wait."""
        self._post(lambda: self._stage.on_frame.remove(self._watching.pop(show)))

    def refresh(self) -> None:
        """Count the session anew once the recorder has written what it holds, then tell it."""
        recorder = self._stage.recorder
        if recorder is None:
            self._post(self._tell)
            return

        def count() -> None:
            record = self._store.session(recorder.session)
            self._totals = Totals(
                {"id": record.id, "name": record.name}, record.takes_kept, record.pairs
            )
            with contextlib.suppress(ConflictError):  # closed meanwhile: nobody to tell
                self._post(self._tell)

        recorder.settle(count)

    def status(self) -> dict[str, Any]:
        """The stage's `Status` and its session's totals, as JSON holds them."""
        return self.call(lambda: self._describe(self._stage.status(time.monotonic())))

    def call(self, work: Callable[[], T]) -> T:
        """Run `work` on the stage's thread and return what it returns, or raise what it raises."""
        if threading.current_thread() is self._thread:
            return work()
        future: Future[T] = Future()

        def run() -> None:
            try:
                future.set_result(work())
            except BaseException as error:
                future.set_exception(error)

        self._post(run)
        return future.result(timeout=PATIENCE_S)

    def close(self) -> bool:
        """End the running take, write it, and stop the thread.

        False where the store refuses for too long: what it lacks then waits in a file.
        """
        with self._wake:
            self._closing = True
            self._wake.notify()
        self._thread.join()
        recorder = self._stage.recorder
        if recorder is None:
            return True
        recorder.close(time.time(), CLOSE_S)
        return not recorder.left

    # -- the thread ----------------------------------------------------------------------------

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            with self._wake:
                while not self._calls and not self._closing:
                    left = due - time.monotonic()
                    if left <= 0.0:
                        break
                    self._wake.wait(left)
                if self._closing and not self._calls:
                    return
                calls = list(self._calls)
                self._calls.clear()
            for call in calls:
                self._safely(call)
            if calls:  # a key may have come just before its decision: what it changes is told first
                self._safely(self._tell_changes)
            recording = self._stage.phase is Phase.RECORDING
            due = min(self._advance(), time.monotonic() + STATUS_S)
            if recording and self._stage.phase is Phase.ENDED:
                self.refresh()
            self._safely(self._tell_changes)

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
        fault = (
            f"The character stopped: {error}"
            if isinstance(error, StudioError)
            else "The scene or the character failed and was stopped; the log tells why."
        )
        if fault != self._fault:
            logger.error("Stage %s stopped", self.name, exc_info=error)
        self._fault = fault
        with contextlib.suppress(Exception):  # the scene may fail at its beginning too
            self._stage.stop(time.time())

    def _post(self, work: Callable[[], None]) -> None:
        with self._wake:
            if self._closing:
                raise ConflictError("This stage is closed; open another.")
            self._calls.append(work)
            self._wake.notify()

    def _tell_changes(self) -> None:
        stage, now = self._stage, time.monotonic()
        recorder = stage.recorder
        key = (
            stage.phase,
            stage.mode,
            stage.run.seed,
            stage.camera,
            stage.clock.pace,
            stage.looked_at,
            stage.decision,
            stage.decision is not None and stage.clock.steps,
            self._totals,
            self._fault,
            recorder is not None and (recorder.problem, recorder.can_undo),
        )
        moving = stage.phase in (Phase.COUNTDOWN, Phase.RECORDING, Phase.PLAYING)
        if key != self._told or (moving and now - self._told_at >= STATUS_S):
            self._told = key
            self._tell()

    def _tell(self) -> None:
        now = time.monotonic()
        self._told_at = now
        if not self.on_status:
            return
        message = self._describe(self._stage.status(now))
        for listener in list(self.on_status):
            listener(message)

    def _describe(self, status: Status) -> dict[str, Any]:
        told = {"stage": self.name, **asdict(status), **asdict(self._totals)}
        return {**told, "problem": status.problem or self._fault}

    def _actor(self, pilot: str, scene: Scene) -> Pilot:
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
