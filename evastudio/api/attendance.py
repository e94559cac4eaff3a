"""Attendance: how many pages drive a stage, and what happens when the last one goes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from evastudio.errors import StudioError
from evastudio.live.live_stage import LiveStage

IDLE_S = 60.0
"""A stage that nobody drives for this long is closed; its running take is kept."""


class Attendance:
    """The pages at one stage. Lives on the event loop."""

    def __init__(self, stage: LiveStage, close: Callable[[], None]) -> None:
        """`close` is called once nobody has driven the stage for a while."""
        self._stage = stage
        self._close = close
        self._present = 0
        self._wait()

    def came(self) -> None:
        """A page connected."""
        self._present += 1
        self._closing.cancel()

    def left(self) -> None:
        """A page went: with the last one every key is released and a running take pauses."""
        self._present -= 1
        if self._present == 0:
            try:
                self._stage.nobody_there()
            except StudioError:
                return  # the stage is closed already
            self._wait()

    def seen(self) -> None:
        """A program drives the stage without being connected."""
        if self._present == 0:
            self._closing.cancel()
            self._wait()

    def end(self) -> None:
        """The stage is closed: wait for nobody."""
        self._closing.cancel()

    def _wait(self) -> None:
        self._closing = asyncio.get_running_loop().call_later(IDLE_S, self._close)
