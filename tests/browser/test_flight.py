"""From held keys to a policy that flies, in real Chromium with real key events."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from tests.browser.acting import FRAMES, at_least, camera, focus_view, phase

if TYPE_CHECKING:
    from conftest import Open


NEXT = """async () => {
  const {nextStep} = await import("/web/js/needs.js");
  const cleaning = {pairs: 9, removed: 0, stale: false};
  const sessions = [{id: 1, name: "Mine", pairs: 9, cleaning}];
  const older = {name: "mine-1", session: "Mine", stale: true, shipped: false};
  const newer = {name: "mine-2", session: "Mine", stale: false, shipped: false};
  return [[older, newer], [older]].map(policies => nextStep({sessions, session: 1, policies}));
}"""
"""What comes next where an older policy lies beside one that is up to date, and alone."""


def test_an_animator_flies_cleans_fits_and_plays(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    opened = open_page()
    studio, stage, frame = opened.studio, opened.stage, opened.view
    page.locator("#option-density").fill("0.5")

    for button in ("#clean", "#fit"):
        expect(page.locator(button)).to_have_attribute("aria-disabled", "true")
        page.locator(button).click(force=True)
        expect(page.locator("#notice")).to_contain_text("ecord a take")

    page.locator("#demonstrate").click()
    phase(page, "countdown")
    phase(page, "recording")
    focus_view(page)
    page.keyboard.down("w")
    page.keyboard.down("ArrowLeft")
    at_least(page, "pairs", 45)

    # While keys are held, the camera stays where the chase puts it.
    page.keyboard.press("Space")
    phase(page, "paused")
    chase = stage.scene.camera(stage.snapshot).position
    assert camera(studio, frame, near=chase) == pytest.approx(chase, abs=1e-3)
    page.keyboard.down("d")
    page.keyboard.down("ArrowUp")
    frame.evaluate(FRAMES, 40)
    assert camera(studio, frame) == pytest.approx(chase, abs=1e-3)
    for key in ("w", "ArrowLeft", "d", "ArrowUp"):
        page.keyboard.up(key)
    page.keyboard.press("Space")
    phase(page, "recording")
    at_least(page, "pairs", 75)
    page.locator("#stop").click()
    phase(page, "ready")
    at_least(page, "takes-kept", 1)

    # The same keys move viser's camera where nobody demonstrates: the check above can fail.
    resting = camera(studio, frame)
    focus_view(page)
    page.keyboard.down("w")
    frame.evaluate(FRAMES, 40)
    page.keyboard.up("w")
    assert np.abs(camera(studio, frame) - resting).max() > 0.1

    with Store(studio.workspace.store_url) as store:
        session = store.sessions()[0]
        (take,) = store.takes(session.id)
        data = store.load_take(take.id)
    assert session.pairs == take.pairs == len(data.actions) >= 75
    assert data.actions[:, 0].max() > 0.1
    assert data.actions[:, 1].max() > 0.1
    assert np.abs(data.snapshots["heading"]).max() > 0.3

    page.locator("#clean").click()
    expect(page.locator("#notice")).to_contain_text("taken out")
    page.locator("label:has(input[name=learner][value=knn])").click()
    page.locator("#fit").click()
    expect(page.locator("#notice")).to_contain_text("ready to play")
    # What is next does not hang on an older policy, which comes first in the list.
    expect(page.locator("#play.next")).to_be_visible()
    assert page.evaluate(NEXT) == ["play", "fit"]
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 2)
    status = stage.status()
    assert status["seed"] != take.seed
    assert status["progress"] > 0.0
    with Store(studio.workspace.store_url) as store:
        assert store.session(session.id).pairs == take.pairs
    page.screenshot(path=pictures / "own-policy.png")
    page.locator("#stop").click()
    phase(page, "ready")


def test_a_take_is_thrown_away_and_brought_back(page: Page, open_page: Callable[[], Open]) -> None:
    studio = open_page().studio
    page.locator("#option-density").fill("0.5")
    page.locator("#demonstrate").click()
    phase(page, "recording")
    focus_view(page)
    page.keyboard.down("a")
    at_least(page, "pairs", 15)
    page.keyboard.up("a")
    page.keyboard.press("r")
    phase(page, "countdown")
    expect(page.locator("#takes-kept")).to_have_text("1")
    phase(page, "recording")
    at_least(page, "pairs", 8)
    page.keyboard.press("Backspace")
    phase(page, "ready")
    expect(page.locator("#takes-kept")).to_have_text("1")
    again = page.locator("#keys button[data-does=restart]")
    expect(again).to_be_visible()
    page.keyboard.press("r")
    phase(page, "countdown")
    page.keyboard.press("Escape")
    phase(page, "ready")
    page.locator("#undo").click()
    expect(page.locator("#takes-kept")).to_have_text("2")
    with Store(studio.workspace.store_url) as store:
        assert store.sessions()[0].takes_kept == 2


def test_a_shipped_policy_flies_out_of_the_box(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    page.set_viewport_size({"width": 1280, "height": 800})
    stage = open_page().stage
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 9)
    page.screenshot(path=pictures / "studio.png")
    assert stage.status()["policy"] == "asteroids-careful"
    page.keyboard.press("Space")
    phase(page, "paused")
    page.locator("#stop").click()
    phase(page, "ready")


def test_a_tab_that_closes_leaves_the_take_whole(page: Page, open_page: Callable[[], Open]) -> None:
    opened = open_page()
    studio, stage = opened.studio, opened.stage
    page.locator("#option-density").fill("0.5")
    page.locator("#demonstrate").click()
    phase(page, "recording")
    page.keyboard.down("a")
    at_least(page, "pairs", 15)
    paused = threading.Event()
    stage.on_status.append(lambda told: told["phase"] == "paused" and paused.set())
    page.goto("about:blank")
    assert paused.wait(30.0)
    with Store(studio.workspace.store_url) as store:
        assert store.sessions()[0].pairs >= 15
