"""What a person does at the page, and what they wait to see there."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Frame, Page, expect

from evastudio.live.live_stage import LiveStage

if TYPE_CHECKING:
    from conftest import Running


FRAMES = """count => new Promise(done => {
  const next = () => (count-- ? requestAnimationFrame(next) : done(true));
  next();
})"""
"""Wait for that many frames to be drawn."""
WAIT_S = 60.0


def phase(page: Page, wanted: str) -> None:
    """Wait until the stage is in that phase."""
    expect(page.locator(f"#phase[data-phase={wanted}]")).to_be_attached()


def at_least(page: Page, element: str, count: float) -> None:
    """Wait until the number that `element` shows is at least `count`."""
    script = "([id, count]) => Number(document.getElementById(id).textContent) >= count"
    page.wait_for_function(script, arg=[element, count])


def focus_view(page: Page) -> None:
    """Click into the 3D view, as a person does."""
    box = page.locator("#view").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert page.evaluate("document.activeElement.id") == "view"


def until(seen: Page | Frame, holds: Callable[[], bool]) -> None:
    """Wait until something holds that the page does not tell, looking after every other frame."""
    ends = time.monotonic() + WAIT_S
    seen.evaluate(FRAMES, 2)
    while not holds():
        assert time.monotonic() < ends, f"it did not come about within {WAIT_S:g} s"
        seen.evaluate(FRAMES, 2)


def camera(studio: Running, frame: Frame, near: np.ndarray | None = None) -> np.ndarray:
    """Where the browser says it looks from; once it is at `near`, where that is given."""
    (stage,) = studio.context.stages.all()
    view = studio.views[stage.name]

    def there() -> bool:
        if not view.cameras:
            return False
        return near is None or bool(np.abs(np.array(view.cameras[0]) - near).max() < 1e-3)

    until(frame, there)
    return np.array(view.cameras[0])


def moment(page: Page, stage: LiveStage, seconds: float, near: float = 0.01) -> None:
    """Wait until the timeline stands there, and the stage too."""
    script = (
        "([s, n, dt]) => Math.abs(document.getElementById('moment').valueAsNumber * dt - s) < n"
    )
    page.wait_for_function(script, arg=[seconds, near, stage.scene.dt_s])
    until(page, lambda: bool(abs(stage.status()["position_s"] - seconds) < near))
