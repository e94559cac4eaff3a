"""The views of a server's stages: each is there while a browser looks at its stage."""

from __future__ import annotations

import asyncio
import contextlib

from starlette.websockets import WebSocket

from evastudio.errors import StudioError
from evastudio.live.live_stage import LiveStage
from evastudio.live.picture import Picture
from evastudio.studio.view import View


class Views:
    """Views by the name of their stage. Lives on the event loop."""

    def __init__(self) -> None:
        self._shown: dict[str, _Shown] = {}

    def __getitem__(self, stage: str) -> View:
        """The view of a stage that somebody looks at. Raises KeyError where nobody does."""
        return self._shown[stage].view

    @property
    def clients(self) -> int:
        """Number of browsers that look at any of them."""
        return sum(shown.looking for shown in self._shown.values())

    async def handle(self, stage: LiveStage, websocket: WebSocket, heard: bool = True) -> None:
        """Serve one browser that looks at `stage`, until it leaves; `heard` as `View` says."""
        shown = self._shown.get(stage.name)
        if shown is None:
            shown = self._shown[stage.name] = _Shown(stage)
        try:
            await shown.handle(websocket, heard)
        finally:
            if not shown.looking:
                self.close(stage.name)

    def close(self, stage: str) -> None:
        """End the view of a stage and every connection to it, if there is one."""
        shown = self._shown.pop(stage, None)
        if shown is not None:
            shown.view.close()

    def close_all(self) -> None:
        for stage in list(self._shown):
            self.close(stage)


class _Shown:
    """A stage that somebody looks at."""

    def __init__(self, stage: LiveStage) -> None:
        self._stage = stage
        self.view = View(stage.scene, asyncio.get_running_loop())
        self.looking = 0

    async def handle(self, websocket: WebSocket, heard: bool) -> None:
        self.looking += 1
        try:
            if self.looking == 1:
                await asyncio.to_thread(self._stage.watch, self._show)
            await self.view.handle(websocket, heard)
        except StudioError:
            await websocket.close(4404, "There is no such stage; load the page again.")
        finally:
            self.looking -= 1
            if not self.looking:
                with contextlib.suppress(StudioError):  # the stage was closed meanwhile
                    self._stage.unwatch(self._show)

    def _show(self, picture: Picture) -> None:
        """On the stage's thread."""
        self.view.scene = self._stage.scene  # it may be the same with other options by now
        self.view.show(picture.snapshot, picture.fresh, picture.camera, picture.lines)
