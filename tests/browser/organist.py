"""A page at the organ (tests/scenes/organ.py), where a key is recorded just as it was held."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from playwright.sync_api import Page, WebSocket

from evastudio.demonstrations.store import Store
from evastudio.live.live_stage import LiveStage
from evastudio.world.spaces import Array
from tests.browser.acting import focus_view, phase
from tests.browser.conftest import enter

if TYPE_CHECKING:
    from conftest import Running

WAIT_S = 60.0
ORGAN = Path(__file__).parents[1] / "scenes" / "organ.py"
WATCHED = """
if (location.protocol.startsWith("http")) {
  localStorage.setItem("evastudio.scene", "organ");
  const note = (event) => {
    const view = event.view ?? window;
    (window.top.felt ??= []).push([
      event.type, event.code, view.performance.timeOrigin + event.timeStamp]);
  };
  for (const type of ["keydown", "keyup"]) window.addEventListener(type, note, { capture: true });
}
"""
"""What the keyboard did, as Chromium tells the page and the view, before either hears of it."""


@dataclass
class Organist:
    """Somebody at the organ, in the middle of a take."""

    page: Page
    studio: Running
    stage: LiveStage = field(init=False)
    told: int = 0
    """Number of the latest message about keys that the page has sent."""
    heard: int = 0
    """Number of the latest of them that the studio has answered."""
    held: tuple[str, ...] = ()
    """Keys that are held, as the page told last."""

    def listen(self, socket: WebSocket) -> None:
        """Follow what goes over the stage's websocket from now on."""
        if socket.url.endswith("/socket"):
            socket.on("framesent", self._sent)
            socket.on("framereceived", self._received)

    def _sent(self, text: str | bytes) -> None:
        told = json.loads(text)
        if told["type"] == "keys":
            self.told, self.held = told["seq"], tuple(told["held"])

    def _received(self, text: str | bytes) -> None:
        told = json.loads(text)
        if told["type"] == "ack":
            self.heard = told["seq"]

    def pairs(self) -> int:
        """Pairs of the take so far."""
        return int(self.stage.status()["pairs"])

    def holds(self, *codes: str) -> int:
        """Wait until the studio knows that just these keys are held; the pairs by then."""
        self.until(lambda: self.held == codes and self.told == self.heard)
        return self.pairs()

    def rest(self, steps: int) -> int:
        """Wait until all that was told was heard, and so many steps more; the pairs by then."""
        self.until(lambda: self.told == self.heard)
        until = self.pairs() + steps
        self.until(lambda: self.pairs() >= until)
        return self.pairs()

    def until(self, so: Callable[[], bool]) -> None:
        """Wait until it is so, looking whenever the stage tells something."""
        told = threading.Event()

        def listener(status: dict[str, Any]) -> None:
            told.set()

        self.stage.on_status.append(listener)
        try:
            for _ in range(1000):
                told.clear()
                self.page.evaluate("0")  # what the browser has told meanwhile is taken in
                if so():
                    return
                assert told.wait(WAIT_S), "the stage tells nothing"
        finally:
            self.stage.on_status.remove(listener)
        raise AssertionError(f"told {self.told}, heard {self.heard}, {self.pairs()} pairs")

    def finish(self) -> Array:
        """Stop; the actions of the take, (pairs, keys), as the store has them."""
        self.page.locator("#stop").click()
        phase(self.page, "ready")
        self.stage.close()
        with Store(self.studio.workspace.store_url) as store:
            (take,) = store.takes(store.sessions()[0].id)
            data = store.load_take(take.id)
        assert take.pairs == len(data.actions)
        assert data.snapshots["steps"].tolist() == list(range(take.pairs))
        return np.asarray(data.actions)


def sit_down(page: Page, studio: Running) -> Organist:
    """Begin a take at the organ."""
    folder = studio.workspace.root / "scenes"
    folder.mkdir()
    (folder / ORGAN.name).write_text(ORGAN.read_text())
    page.set_viewport_size({"width": 640, "height": 360})
    page.add_init_script(WATCHED)
    organist = Organist(page, studio)
    page.on("websocket", organist.listen)
    organist.stage = enter(page, studio).stage
    page.locator("#demonstrate").click()
    phase(page, "recording")
    focus_view(page)
    return organist
