"""What a person does about what plays: take over from it, ask why it did that, make it forget."""

from __future__ import annotations

import contextlib
import copy
import time
from typing import TYPE_CHECKING

import numpy as np

from evastudio.demonstrations.by_hand import mark_by_hand
from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, NotFoundError
from evastudio.learning.learner import Indices
from evastudio.learning.neighbor_learner import NeighborLearner
from evastudio.learning.policy import Policy
from evastudio.live.perceiving import see_session
from evastudio.live.pushing import Pushes, Shown
from evastudio.live.stage import Stage
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.why import Reasoner, Why
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene

if TYPE_CHECKING:
    from evastudio.live.live_stage import LiveStage


class Correcting:
    """The part of a live stage that changes what plays. Callable from any thread."""

    def __init__(self, live: LiveStage, stage: Stage, workspace: Workspace, store: Store) -> None:
        self._live = live
        self._stage = stage
        self._workspace = workspace
        self._store = store
        self._forgotten: dict[tuple[int, int], None] = {}

    def take_over(self) -> None:
        """Go on by hand from what plays; see `Stage.take_over`."""
        self._live.need_session()
        self._live.pulse.call(lambda: self._stage.take_over(time.monotonic(), time.time()))

    def hand_back(self) -> None:
        """See `Stage.hand_back`."""
        self._live.pulse.call(lambda: self._stage.hand_back(time.time()))
        self._live.refresh()

    def why(self) -> Why | None:
        """See `Act.why`."""
        return self._live.pulse.call(lambda: self._stage.act.why())

    def silence(self, why: Why) -> str | None:
        """See `Reasoner.silence`."""
        reasoner = self._stage.present.actors.reasoner
        return None if reasoner is None else reasoner.silence(why)

    def forget(self, take: int, step: int) -> None:
        """Leave a demonstrated moment out: what plays decides without it at once, and so does
        every policy fitted to its session from now on.

        Raises ConflictError where nothing plays that could forget, NotFoundError where it has not
        learned from that moment.
        """
        reasoner = self._stage.present.actors.reasoner
        if reasoner is None:
            raise ConflictError("Nothing plays that could forget. Press Play first.")
        pilot, pairs = reasoner.holder(take, step)
        policy = pilot.policy
        if isinstance(policy.learner, NeighborLearner):
            self._live.pulse.call(lambda: leave_out(pilot, pairs))
        else:  # fitted anew, which the stage does not wait for
            pilot.policy = copy.deepcopy(policy).without(pairs)
        try:
            self._mark(policy, take, step)
        finally:  # it is forgotten, even where the store cannot be told
            self._live.pulse.call(self._stage.rethink)
        self._live.refresh()

    def forget_again(self, reasoner: Reasoner) -> None:
        """Let policies that were read anew forget what was left out on this stage before, unless
        that was taken back meanwhile."""
        for take, step in list(self._forgotten):
            with contextlib.suppress(NotFoundError):  # fitted without it, or another policy
                pilot, pairs = reasoner.holder(take, step)
                if pilot.policy.extra.get("store") == self._store.identity:
                    if self._left_out(take, step):
                        leave_out(pilot, pairs)
                    else:
                        del self._forgotten[take, step]

    def _mark(self, policy: Policy, take: int, step: int) -> None:
        """Let nothing be fitted to a moment that `policy` forgot, where it is of this store."""
        if policy.extra.get("store") == self._store.identity:
            self._forgotten[take, step] = None
            with contextlib.suppress(NotFoundError, ConflictError):  # thrown away
                mark_by_hand(self._store, take, step, True, time.time())

    def pushes(self, scene: Scene, rng: np.random.Generator) -> Pushes:
        """What forces a character off its way, to where the takes of the session were not yet."""
        recorder, shown = self._stage.recorder, None
        session = None if recorder is None else self._store.session(recorder.session)
        if session is not None and session.pairs > 1:
            (seen,) = see_session(self._workspace, self._store, session)
            pairs = seen.pairs()
            if len(pairs) > 1:
                shown = Shown(seen.perception, pairs.states, pairs.takes)
        return Pushes(scene, rng, shown)

    def _left_out(self, take: int, step: int) -> bool:
        marks = self._store.marks(self._store.take(take).session).get(take)
        return marks is not None and step < len(marks) and bool(marks[step])


def leave_out(pilot: PolicyPilot, pairs: Indices) -> None:
    """Let `pilot` decide without those of the pairs that its policy keeps, from now on."""
    pilot.policy = pilot.policy.without(pairs)
