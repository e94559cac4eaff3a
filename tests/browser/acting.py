"""What a person does at the page, and what they wait to see there."""

from __future__ import annotations

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


def camera(studio: Running, frame: Frame, near: np.ndarray | None = None) -> np.ndarray:
    """Where the browser says it looks from; once it is at `near`, where that is given."""
    (stage,) = studio.context.stages.all()
    view = studio.views[stage.name]
    for _ in range(200):
        frame.evaluate(FRAMES, 2)
        told = np.array(view.cameras[0]) if view.cameras else None
        if told is not None and (near is None or np.abs(told - near).max() < 1e-3):
            return told
    raise AssertionError(f"the camera is at {view.cameras}, expected {near}")


def moment(page: Page, stage: LiveStage, seconds: float, near: float = 0.01) -> None:
    """Wait until the timeline stands there, and the stage too."""
    script = (
        "([s, n, dt]) => Math.abs(document.getElementById('moment').valueAsNumber * dt - s) < n"
    )
    page.wait_for_function(script, arg=[seconds, near, stage.scene.dt_s])
    for _ in range(200):
        page.evaluate(FRAMES, 2)
        if abs(stage.status()["position_s"] - seconds) < near:
            return
    raise AssertionError(f"the stage is at {stage.status()['position_s']} s, expected {seconds} s")
