"""Switching between two policies, in real Chromium: by an event, and as the marks say."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

import evastudio
from evastudio.learning.switch import load_switch

if TYPE_CHECKING:
    from conftest import Open, Running


def test_a_switch_is_made_and_plays(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    evastudio.record(
        studio.workspace,
        "crowd",
        "scripted:surprised",
        minutes=1.5,
        options={"people": 8.0, "side": 12.0},
        session="Startled",
        mark="event:impact",
    )
    page.set_viewport_size({"width": 1280, "height": 1000})
    open_page(studio)
    page.locator("#scene").select_option("crowd")
    expect(page.locator("#policy")).to_contain_text("crowd-and-boulder")
    page.locator("#switch-box summary").click()
    assert page.locator("#switch-when").input_value() == "once event:falling"
    page.locator("#switch-first").select_option("crowd-shy")
    page.locator("#switch-then").select_option("crowd-shy")
    page.locator("#switch-name").fill("none")
    page.locator("#switch-form button[type=submit]").click()
    expect(page.locator("#notice")).to_contain_text("two different policies")
    page.locator("#switch-then").select_option("crowd-fleeing")
    page.locator("#switch-when").select_option(label="as I marked in “Startled”")
    page.locator("#switch-name").fill("as-marked")
    page.screenshot(path=pictures / "switching.png")
    page.locator("#switch-form button[type=submit]").click()
    expect(page.locator("#switch-form .job")).to_be_visible()
    expect(page.locator("#notice")).to_contain_text("“as-marked” is ready to play.")
    expect(page.locator("#play-says")).to_contain_text(
        "crowd-shy; once the boulder has hit the ground, crowd-fleeing."
    )
    page.locator("#switch-when").select_option("after")
    page.locator("#switch-seconds").fill("2.5")
    page.locator("#switch-name").fill("by-time")
    page.locator("#switch-form button[type=submit]").click()
    expect(page.locator("#play-says")).to_contain_text(
        "crowd-shy; when the time is over 2.5 s, crowd-fleeing."
    )
    learned = load_switch(studio.workspace.policies / "as-marked.switch.json")
    assert learned.entries[0].learned is not None
    page.locator("#play").click()
    expect(page.locator("#phase")).to_contain_text("Playing by-time")
    expect(page.locator("#seconds")).to_contain_text("3.")
