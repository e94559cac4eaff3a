"""The guided tour, taken in real Chromium by keys alone: timed, kept only where one agreed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from evastudio.evaluation.studies import studies
from tests.browser.acting import at_least, focus_view, phase
from tests.browser.conftest import WAIT_MS

if TYPE_CHECKING:
    from conftest import Open, Running

STEPS = {
    "Take the keys": "#demonstrate",
    "Steer": "#keys li[data-use=steer]",
    "Show how it should move": "#stage .numbers",
    "Clean": "#clean",
    "Fit": "#fit",
    "Play": "#play",
}
"""What the tour points at."""
BESIDE = """target => {
  const card = document.getElementById("tour").getBoundingClientRect();
  const ring = document.getElementById("tour-ring").getBoundingClientRect();
  const one = document.querySelector(target).getBoundingClientRect();
  const apart = card.right <= ring.left || card.left >= ring.right
    || card.bottom <= ring.top || card.top >= ring.bottom;
  const round = ring.left <= one.left && ring.right >= one.right
    && ring.top <= one.top && ring.bottom >= one.bottom;
  const seen = card.left >= 0 && card.top >= 0 && card.right <= innerWidth
    && card.bottom <= innerHeight;
  const gap = Math.max(ring.left - card.right, card.left - ring.right,
    ring.top - card.bottom, card.top - ring.bottom);
  return apart && round && seen && gap < 24;
}"""
"""Whether the card stands close to what it points at, all in the window, and covers none of it."""


def told(studio: Running) -> list[tuple[str, str]]:
    with Store(studio.workspace.store_url) as store:
        return [(one.scene, one.person) for one in studies(store)]


def at_step(page: Page, title: str) -> None:
    """Wait until the tour is at the step of that title, and points at what it is about.

    Work that a step waits for is done by a process that begins anew, which may take long.
    """
    expect(page.locator("#tour-title")).to_have_text(title, timeout=3 * WAIT_MS)
    page.wait_for_function(BESIDE, arg=STEPS[title])
    assert (page.locator("#tour-live").text_content() or "").startswith(title)


def test_the_tour_leads_to_a_policy_that_plays_and_keeps_its_times(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    page.set_viewport_size({"width": 1120, "height": 700})
    studio = open_page().studio
    expect(page.locator("#tour-title")).to_have_text("New here?")
    page.locator("#option-density").fill("0.1")
    page.locator("#tour-agrees").focus()
    page.keyboard.press("Space")
    page.keyboard.type("animator, a program in a test")
    page.keyboard.press("Enter")

    at_step(page, "Take the keys")
    page.keyboard.press("Enter")
    at_step(page, "Steer")
    phase(page, "recording")
    focus_view(page)
    page.keyboard.down("ArrowLeft")
    at_step(page, "Show how it should move")
    page.screenshot(path=pictures / "tour.png")
    page.keyboard.up("ArrowLeft")
    page.keyboard.press("r")
    phase(page, "countdown")
    phase(page, "recording")
    at_least(page, "pairs", 130)
    page.keyboard.press("Escape")
    for title in ("Clean", "Fit", "Play"):
        at_step(page, title)
        page.keyboard.press("Enter")
    phase(page, "playing")
    expect(page.locator("#tour-title")).to_have_text("That is all")
    expect(page.locator("#tour-says")).to_contain_text("Both are kept")

    with Store(studio.workspace.store_url) as store:
        (kept,) = studies(store)
        session = store.sessions()[0]
    assert (kept.scene, kept.person) == ("asteroids", "animator, a program in a test")
    assert kept.demonstrated_s == pytest.approx(session.seconds)
    assert kept.instructed_s is not None
    assert 0.0 < kept.instructed_s < 120.0
    page.locator("#tour-forget").click()
    expect(page.locator("#tour-says")).to_have_text("Your times are forgotten.")
    assert told(studio) == []
    page.locator("#tour-go").click()
    expect(page.locator("#tour")).to_be_hidden()


def test_every_step_can_be_skipped_and_nothing_is_kept_of_who_did_not_agree(
    page: Page, open_page: Callable[[], Open]
) -> None:
    studio = open_page().studio
    expect(page.locator("#tour-title")).to_have_text("New here?")
    page.keyboard.press("h")
    for title in STEPS:
        at_step(page, title)
        page.locator("#tour-skip").click()
    expect(page.locator("#tour-title")).to_have_text("That is all")
    page.locator("#tour-go").click()
    expect(page.locator("#tour")).to_be_hidden()

    page.reload()
    phase(page, "ready")
    expect(page.locator("#session option").first).to_be_attached()
    expect(page.locator("#pairs-kept")).to_have_text("0")
    expect(page.locator("#tour")).to_be_hidden()
    page.keyboard.press("h")
    expect(page.locator("#tour-title")).to_have_text("New here?")
    page.keyboard.press("h")
    at_step(page, "Take the keys")
    page.keyboard.press("h")
    expect(page.locator("#tour")).to_be_hidden()
    assert told(studio) == []
