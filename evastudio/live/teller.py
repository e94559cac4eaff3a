"""Who tells how a live stage stands: at once when it changes, and often while it moves."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.errors import ConflictError, StudioError
from evastudio.live.act import MOVING
from evastudio.live.pulse import Pulse
from evastudio.live.series import Series
from evastudio.live.stage import Stage

logger = logging.getLogger(__name__)

STATUS_S = 0.125
"""While a stage moves its status is told this often, and at once when it changes phase; what others
change, as a store that takes pairs again, is seen within this time."""


@dataclass(frozen=True)
class Totals:
    """What the store holds of the stage's session."""

    session: Mapping[str, Any] | None
    takes_kept: int
    pairs_kept: int


class Teller:
    """Tells what a person needs to know of a stage. On the stage's thread, but for `refresh`."""

    def __init__(self, name: str, stage: Stage, store: Store, series: Series) -> None:
        self.on_status: list[Callable[[dict[str, Any]], None]] = []
        """Called on the stage's thread; must not wait."""
        self.fault: str | None = None
        """What went wrong last, until somebody asks for something new."""
        self._name = name
        self._stage = stage
        self._store = store
        self._series = series
        self._totals = Totals(None, 0, 0)
        self._asked = self._counted = 0
        self._told_at = 0.0
        self._told: tuple[Any, ...] = ()

    @property
    def kept(self) -> int | None:
        """Takes that the session has; None while that is being counted."""
        return self._totals.takes_kept if self._counted >= self._asked else None

    def refresh(self, pulse: Pulse) -> None:
        """Count the session anew once the recorder has written what it holds, then tell it through
        `pulse`."""
        recorder = self._stage.recorder
        if recorder is None:
            pulse.post(self.tell)
            return

        def count() -> None:
            try:
                record = self._store.session(recorder.session)
                self._totals = Totals(
                    {"id": record.id, "name": record.name}, record.takes_kept, record.pairs
                )
            finally:  # who waits for the count waits no longer, whatever came of it
                self._counted = max(self._counted, asked)
            with contextlib.suppress(ConflictError):  # closed meanwhile: nobody to tell
                pulse.post(self.tell)

        self._asked = asked = self._asked + 1
        recorder.settle(count)

    def failed(self, error: Exception) -> None:
        """Keep what went wrong, in words for a person; it is logged once where it goes on."""
        fault = (
            f"The character stopped: {error}"
            if isinstance(error, StudioError)
            else "The scene or the character failed and was stopped; the log tells why."
        )
        if fault != self.fault:
            logger.error("Stage %s stopped", self._name, exc_info=error)
        self.fault = fault

    def tell_changes(self) -> None:
        """Tell where something changed, or it is time to."""
        stage, act, now = self._stage, self._stage.act, time.monotonic()
        review, recorder, clock = stage.look_back, stage.recorder, stage.clock
        decision = act.decision(clock.interval)
        key = (
            act.phase,
            act.mode,
            act.run.seed,
            stage.camera,
            clock.pace,
            review and (act.run.reel.origin.take, review.position, review.speed),
            stage.rethought,
            act.pushed,
            decision,
            decision is not None and clock.steps,
            stage.coach.advice,
            self._series.arrangement,
            self._series.next_at,
            self._totals,
            self.fault,
            recorder is not None and (recorder.problem, recorder.can_undo),
        )
        if key != self._told or (act.phase in MOVING and now - self._told_at >= STATUS_S):
            self._told = key
            self.tell()

    def tell(self) -> None:
        """Tell all who listen."""
        self._told_at = time.monotonic()
        if self.on_status:
            message = self.status()
            for listener in list(self.on_status):
                listener(message)

    def status(self) -> dict[str, Any]:
        """The stage's `Status` and its session's totals, as JSON holds them."""
        now = time.monotonic()
        status, series = self._stage.status(now), self._series.told(now)
        told = {"stage": self._name, **vars(status), **vars(self._totals), **series}
        return {**told, "problem": status.problem or self.fault}
