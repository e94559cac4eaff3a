"""What a person does with what was recorded: look back at it, go on from it, keep its end."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING

from evastudio.demonstrations.records import RECORDED, Origin, TakeRecord
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.trimming import keep_last
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.live.comparing import sketch_of
from evastudio.live.conflicts import find_conflicts
from evastudio.live.footage import Footage, file_name, footage_of
from evastudio.live.headless import make_scene
from evastudio.live.pulse import PATIENCE_S
from evastudio.live.pushing import Push
from evastudio.live.reel import Reel
from evastudio.live.stage import Stage
from evastudio.live.strip import Strip, strip_of
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene
from evastudio.world.snapshot import Snapshot

if TYPE_CHECKING:
    from evastudio.live.live_stage import LiveStage


class LookingBack:
    """The part of a live stage that reaches into the past. Callable from any thread."""

    def __init__(self, live: LiveStage, stage: Stage, workspace: Workspace, store: Store) -> None:
        self._live = live
        self._stage = stage
        self._workspace = workspace
        self._store = store

    def review(self, take: int | None = None, at_s: float = 0.0) -> None:
        """Look back at a take, or at the run that is on the stage, from `at_s` on."""
        self._live.begin_again()
        stage = self._stage
        reel, seed = (stage.present.run.reel, None) if take is None else self._reel(take)
        at = _steps(at_s, reel.scene)
        self._live.pulse.call(lambda: stage.review(reel, at, time.monotonic(), seed))

    def compare(self, take: int, step: int) -> None:
        """Look at a recorded pair beside what was done in moments like it; see `find_conflicts`.

        The moment is the one that the action answered; where each action leads is drawn over it.
        Raises NotFoundError where nobody has looked for conflicts, or not there.
        """
        self._live.begin_again()
        stage, session = self._stage, self._store.session(self._store.take(take).session)
        found = find_conflicts(self._workspace, self._store.identity, session)
        row = found.row(take, step)
        reel, seed = self._reel(take)
        at = step - found.about.delay_steps
        lines = sketch_of(found, row, reel, at)

        def show() -> None:
            stage.review(reel, float(at), time.monotonic(), seed)
            stage.sketch(lines)

        self._live.pulse.call(show)

    def leave(self) -> None:
        """See `Stage.leave`."""
        self._live.pulse.call(self._stage.leave)

    def seek(self, at_s: float) -> None:
        """Look at that second of the run."""
        at = _steps(at_s, self._stage.scene)
        self._live.pulse.call(lambda: self._stage.seek(at, time.monotonic()))

    def roll(self, speed: float) -> None:
        """See `Review.roll`."""
        self._live.pulse.call(lambda: self._stage.roll(speed, time.monotonic()))

    def fork(self, others: str | None = None) -> None:
        """Begin a take at the moment that is looked at, or at the present one.

        `others` is as in `LiveStage.demonstrate`.
        """
        start, origin = self._live.pulse.call(self._stage.here)
        if self._stage.scene.outcome(start)[0]:
            raise ConflictError("The world had ended there. Go back a little, and on from there.")
        self.fork_from(start, self._recorded(origin), others)

    def fork_from(
        self,
        start: Snapshot,
        origin: Origin,
        others: str | None,
        scene: Scene | None = None,
        seed: int | None = None,
    ) -> None:
        """Begin a take at `start`, which `origin` names, of the world of `seed` in `scene`, or of
        the one on the stage."""
        live, stage = self._live, self._stage
        place = stage.scene if scene is None else scene
        live.begin_again()
        crowd = None if others is None else live.actor(others, place)
        live.need_session()
        world = stage.run.seed if seed is None else seed
        live.pulse.call(
            lambda: stage.demonstrate(
                place, world, time.monotonic(), time.time(), crowd, start, origin
            )
        )
        live.refresh()

    def visit(self, take: int, step: int, push: Push, others: str | None = None) -> None:
        """Begin a take where `push` leads from that moment of a take, which nobody has shown.

        `others` is as in `LiveStage.demonstrate`. Raises NotFoundError for an unknown take,
        InvalidInputError for a step that it has not, ConflictError where the push ends the world.
        """
        reel, seed = self._reel(take)
        if step >= reel.last:
            raise InvalidInputError(
                f"The take has no moment {step}; it has {reel.last}, from 0 on."
            )
        start = push.applied(reel.scene, reel.moment(step))
        if reel.scene.outcome(start)[0]:
            raise ConflictError("That push ends the world at once. Choose another.")
        self.fork_from(start, Origin(step, take=take), others, reel.scene, seed)

    def keep_last(self, seconds: float, take: int | None = None) -> None:
        """Keep the last `seconds` of `take` only, and look at what is kept.

        Without one, end the running take, or take the last one. Raises ConflictError where there
        is none, InvalidInputError where the take is shorter.
        """
        if take is None:
            self._live.end_take()
            recorder = self._stage.recorder
            key = None if recorder is None else recorder.last_key
            if key is None:
                raise ConflictError("There is no take to keep the end of. Demonstrate first.")
            keep_last(self._store, self._written(key).id, seconds, time.time())
        else:
            recorder = self._stage.recorder
            key = None if recorder is None else recorder.running_key
            if key is not None and self._written(key).id == take:
                self._live.stop()
            self.review(keep_last(self._store, take, seconds, time.time()))
        self._live.refresh()

    def strip(self) -> Strip:
        """What there is to see in the run that is looked at."""
        stage = self._stage
        reel, moments = self._live.pulse.call(lambda: (stage.run.reel, stage.run.reel.moments()))
        return strip_of(reel, moments)

    def footage(self) -> Footage:
        """The run that is looked at, or the present one, as far as it has gone.

        Raises ConflictError where nothing has moved yet.
        """
        stage = self._stage
        run, moments, camera = self._live.pulse.call(
            lambda: (stage.run, stage.run.reel.moments(), stage.camera)
        )
        scene, take, policy = run.scene, run.reel.origin.take, run.reel.origin.policy
        if take is not None and run.reel.origin.step == 0:
            record = self._store.take(take)
            what, name = f"take {record.number}", f"take-{take}"
        else:
            what, name = policy or "a run", f"{file_name(policy or 'run')}-{run.seed}"
        name = f"{file_name(scene.name)}-{name}-{len(moments)}"
        return footage_of(run.reel, moments, camera, name, f"{scene.title}: {what}")

    def _recorded(self, origin: Origin) -> Origin:
        """`origin`, a moment of the run that is looked at, as one of the take that the run is."""
        reel = self._stage.run.reel
        if reel.key is None:
            return origin
        with contextlib.suppress(NotFoundError):  # thrown away for good
            take = self._written(reel.key).id
            return Origin(origin.step - reel.origin.step, take=take, seed=reel.origin.seed)
        return origin

    def _written(self, key: str) -> TakeRecord:
        """The take that its recorder calls `key`, once it is in the store. Raises NotFoundError."""
        recorder, written = self._stage.recorder, threading.Event()
        if recorder is not None:
            recorder.settle(written.set)
            written.wait(PATIENCE_S)
        return self._store.find_take(key)

    def _reel(self, take: int) -> tuple[Reel, int | None]:
        """Of a recorded take, and its seed. Raises NotFoundError, ConflictError for one of another
        scene."""
        record = self._store.take(take)
        session = self._store.session(record.session)
        scene = make_scene(self._workspace, session.scene, record.options)
        if (session.scene, record.scene_version) != (self._stage.scene.name, scene.version):
            raise ConflictError(
                f"Take {record.number} of {session.name!r} is of scene {session.scene!r} version "
                f"{record.scene_version}; this stage shows {self._stage.scene.name!r} version "
                f"{self._stage.scene.version}."
            )
        reel = Reel.of_take(scene, record, self._store.load_take(take))
        return reel, None if record.seed == RECORDED else record.seed


def _steps(seconds: float, scene: Scene) -> float:
    """`seconds` in decision steps; at a step where they are one but for rounding."""
    return round(seconds / scene.dt_s, 6)
