"""The views of a server's stages and lineups: each is there while a browser looks at it."""

from __future__ import annotations

import asyncio
import contextlib

from starlette.websockets import WebSocket

from evastudio.errors import StudioError
from evastudio.live.lineup import Column
from evastudio.live.picture import Picture, Shown
from evastudio.studio.scheme import Scheme
from evastudio.studio.view import View


class Views:
    """Views by their stage, and by what the pages around them are in. Lives on the event loop."""

    def __init__(self) -> None:
        self._shown: dict[tuple[str, Scheme | None], _Shown] = {}

    def __getitem__(self, stage: str) -> View:
        """A view of a stage that somebody looks at. Raises KeyError where nobody does."""
        for (name, _), shown in self._shown.items():
            if name == stage:
                return shown.view
        raise KeyError(stage)

    @property
    def clients(self) -> int:
        """Number of browsers that look at any of them."""
        return sum(shown.looking for shown in self._shown.values())

    async def handle(
        self,
        stage: Shown,
        websocket: WebSocket,
        heard: bool = True,
        scheme: Scheme | None = None,
    ) -> None:
        """Serve one browser that looks at `stage`, until it leaves; `heard` as `View` says."""
        key = stage.name, scheme
        shown = self._shown.get(key)
        if shown is None:
            shown = self._shown[key] = _Shown(stage, scheme)
        try:
            await shown.handle(websocket, heard)
        finally:
            if not shown.looking and self._shown.get(key) is shown:
                del self._shown[key]
                shown.view.close()

    def close(self, stage: str) -> None:
        """End the views of a stage and every connection to them, if there are any."""
        for key in [key for key in self._shown if key[0] == stage]:
            self._shown.pop(key).view.close()

    def close_all(self) -> None:
        for stage in {name for name, _ in self._shown}:
            self.close(stage)


class _Shown:
    """A stage or a column that somebody looks at."""

    def __init__(self, stage: Shown, scheme: Scheme | None) -> None:
        self._stage = stage
        turned = stage.turned if isinstance(stage, Column) else None
        self.view = View(stage.scene, asyncio.get_running_loop(), scheme, turned)
        self.looking = 0

    async def handle(self, websocket: WebSocket, heard: bool) -> None:
        self.looking += 1
        try:
            if self.looking == 1:
                await asyncio.to_thread(self._stage.watch, self._show)
            await self.view.handle(websocket, heard)
        except StudioError:
            await websocket.close(4404, "There is no such view; load the page again.")
        finally:
            self.looking -= 1
            if not self.looking:
                with contextlib.suppress(StudioError):  # the stage was closed meanwhile
                    self._stage.unwatch(self._show)

    def _show(self, picture: Picture) -> None:
        """On the stage's thread."""
        self.view.scene = self._stage.scene  # it may be the same with other options by now
        self.view.show(picture.snapshot, picture.fresh, picture.camera, picture.lines)
