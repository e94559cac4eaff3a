"""The crowd, in real Chromium with real keys: one is led, thirty are released, a boulder falls."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from evastudio.demonstrations.pairs import perceive_take
from evastudio.demonstrations.replay import replay_take
from evastudio.demonstrations.store import Store
from evastudio.live.aim import ground_at
from evastudio.live.live_stage import LiveStage
from tests.browser.acting import at_least, focus_view, phase

if TYPE_CHECKING:
    from conftest import Open, Running

WAIT_S = 60.0
MARKS = 5
"""The component of an action that marks a moment."""
SYMBOLS = ("stand", "turn left", "turn right", "walk on")
COMING = """() => {
  window.coming = [];
  const note = () => {
    const now = document.querySelector("#decisions .coming")?.textContent;
    if (now && now !== window.coming.at(-1)) window.coming.push(now);
  };
  new MutationObserver(note).observe(document.getElementById("decisions"),
    { subtree: true, attributes: true });
  note();
}"""
"""Keep a list of what the page shows as the next decision."""


def choose_crowd(page: Page, studio: Running) -> LiveStage:
    """Choose the scene on the page; the stage that then opens, once it draws."""
    before = page.locator("#view").get_attribute("src")
    page.locator("#scene").select_option("crowd")
    expect(page.locator("#view")).not_to_have_attribute("src", before or "")
    page.frame_locator("#view").locator("canvas[data-engine]").wait_for()
    expect(page.locator("#signal-drop")).to_be_visible()
    if "EVASTUDIO_PICTURES" in os.environ:  # in full, where drawing by software is slow
        page.evaluate("document.getElementById('view').src += '?fixedDpr=1'")
        page.frame_locator("#view").locator("canvas[data-engine]").wait_for()
    (stage,) = [one for one in studio.context.stages.all() if one.scene.name == "crowd"]
    return stage


def once(stage: LiveStage, true: Callable[[], bool]) -> None:
    """Wait until that is true of the stage."""
    met = threading.Event()
    stage.on_status.append(lambda told: met.set() if true() else None)
    assert met.wait(WAIT_S)
    stage.on_status.pop()


def comes_to(page: Page, was: str, now: str) -> None:
    """Wait until the page has shown `was` as the next decision, and now shows `now`."""
    script = "was => window.coming.at(-2) === was[0] && window.coming.at(-1) === was[1]"
    page.wait_for_function(script, arg=[was, now])


def falls(page: Page, count: int) -> None:
    """Wait until that many more decisions have been recorded."""
    at_least(page, "pairs", int(page.locator("#pairs").inner_text()) + count)


def point(page: Page, across: float, down: float) -> tuple[float, float, float]:
    """Move the mouse to that share of the view; the place in the view as the stage is told it."""
    box = page.locator("#view").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + across * box["width"], box["y"] + down * box["height"])
    return 2 * across - 1, 1 - 2 * down, box["width"] / box["height"]


def since_s(stage: LiveStage) -> float:
    """Seconds since the boulder was let go; -1 before."""
    return float(stage.snapshot["boulder"][0, 2])


def test_an_animator_leads_one_releases_thirty_and_they_run(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    if "EVASTUDIO_PICTURES" in os.environ:
        page.set_viewport_size({"width": 1280, "height": 800})
    studio = open_page().studio
    stage = choose_crowd(page, studio)
    page.locator("#option-people").fill("30")
    drop = page.locator("#signal-drop")
    drop.click(force=True)
    expect(page.locator("#notice")).to_contain_text("Nothing moves")

    # Among people who stand still: a tap, a hold, a tap, each announced before it falls.
    page.locator("#demonstrate").click()
    phase(page, "recording")
    focus_view(page)
    page.evaluate(COMING)
    falls(page, 1)
    page.keyboard.press("a")
    comes_to(page, "turn left", "stand")
    falls(page, 1)
    page.keyboard.down("ArrowUp")
    comes_to(page, "stand", "walk on")
    falls(page, 16)
    page.keyboard.up("ArrowUp")
    comes_to(page, "walk on", "stand")
    falls(page, 1)
    page.keyboard.press("d")
    comes_to(page, "turn right", "stand")
    falls(page, 1)
    page.locator("#another").click(force=True)
    expect(page.locator("#notice")).to_contain_text("about one character")
    focus_view(page)
    page.keyboard.press("c")
    page.keyboard.press("m")
    expect(page.locator("#notice")).to_contain_text("Marked at")
    expect(page.locator("#notice .error")).to_have_count(0)
    falls(page, 1)
    page.locator("#stop").click()
    phase(page, "ready")
    at_least(page, "takes-kept", 1)
    shown = ["stand", "turn left", "stand", "walk on", "stand", "turn right", "stand"]
    assert page.evaluate("window.coming") == shown

    with Store(studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id)
        data = store.load_take(take.id)
    scene = stage.scene
    assert data.actions[:, 0, MARKS].sum() == 1.0
    told = perceive_take(scene.perception(), data.snapshots, data.actions, take.id)
    symbols = [SYMBOLS[int(code)] for code in told.actions[:, 0]]
    assert [name for name, _ in groupby(symbols)] == shown
    assert symbols.count("turn left") == symbols.count("turn right") == 1
    assert symbols.count("walk on") >= 12
    position = data.snapshots["position"]
    assert position.shape[1] == 30
    assert np.array_equal(position[-1, 1:], position[0, 1:])
    again = replay_take(scene, take, data)
    assert np.array_equal(again["position"], position)

    # What was shown is learned by all thirty.
    page.locator("#fit").click()
    expect(page.locator("#notice")).to_contain_text("ready to play")
    page.locator("#play").click()
    phase(page, "playing")
    page.keyboard.press("m")
    expect(page.locator("#notice")).to_contain_text("marked in a take")
    start = stage.snapshot["position"][0]
    at_least(page, "seconds", 4)
    assert len(start) == 30
    assert (stage.snapshot["position"][0] != start).any(axis=1).sum() >= 5

    # And then the boulder, where the pointer is.
    page.locator("#policy").select_option("crowd-and-boulder")
    page.locator("#play").click()
    phase(page, "playing")
    page.keyboard.press("v")
    expect(page.locator("#camera")).to_contain_text("overview")
    expect(page.locator("#deciding")).to_be_visible()
    at_least(page, "seconds", 4)
    page.screenshot(path=pictures / "crowd-before.png")
    place = point(page, 0.55, 0.45)
    aimed = ground_at(scene.cameras(stage.snapshot)["overview"], *place)
    page.keyboard.press("b")
    once(stage, lambda: since_s(stage) >= 2.0)
    running = stage.snapshot
    page.screenshot(path=pictures / "crowd-after.png")
    boulder = running["boulder"][0, :2]
    assert boulder == pytest.approx(aimed, abs=2.0)
    once(stage, lambda: since_s(stage) >= running["boulder"][0, 2] + 1.0)
    later = stage.snapshot
    up = later["hit"][0] == 0
    away = [np.hypot(*(moment["position"][0] - boulder).T)[up] for moment in (running, later)]
    assert (away[1] - away[0] > 2.0).all()
    assert (later["speed"][0, up] > 3.0).all()
    expect(page.locator("#deciding")).to_be_hidden()


def test_buttons_ask_for_a_place_and_a_policy_moves_the_others(
    page: Page, open_page: Callable[[], Open]
) -> None:
    studio = open_page().studio
    stage = choose_crowd(page, studio)
    page.locator("#option-people").fill("8")
    page.locator("#others").select_option("crowd-and-boulder")
    page.locator("#another").click()
    page.locator("#demonstrate").click()
    phase(page, "recording")
    assert stage.status()["lead"] == 1
    start = stage.snapshot["position"][0]
    at_least(page, "pairs", 4)
    moved = np.hypot(*(stage.snapshot["position"][0] - start).T)
    assert moved[1] == 0.0
    assert np.median(moved) > 0.5

    page.locator("#signal-drop").click()
    expect(page.locator("#notice")).to_contain_text("Click in the view")
    looks = page.frame_locator("#view").locator("html.picking")
    expect(looks).to_be_attached()
    place = point(page, 0.4, 0.6)
    aimed = ground_at(stage.scene.cameras(stage.snapshot)["chase"], *place)
    page.mouse.down()
    page.mouse.up()
    expect(looks).not_to_be_attached()
    once(stage, lambda: since_s(stage) >= 0.0)
    assert stage.snapshot["boulder"][0, :2] == pytest.approx(aimed, abs=1e-6)
    page.keyboard.press("r")
    phase(page, "countdown")
    assert stage.status()["others"] == "crowd-and-boulder"
    assert stage.status()["lead"] == 1
