"""Choose for me, in real Chromium: a policy, and in plain sentences what was found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

import evastudio

if TYPE_CHECKING:
    from conftest import Open, Running


def test_the_studio_chooses_and_says_what_it_found(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    evastudio.record(studio.workspace, "asteroids", minutes=1.5, seed=4, session="Calm")
    page.set_viewport_size({"width": 1280, "height": 900})
    open_page(studio)
    page.locator("label:has(input[name=learner][value=auto])").click()
    expect(page.locator("#fit-says")).to_contain_text("they have not seen")
    page.locator("#fit").click()
    expect(page.locator("#fit-report")).to_contain_text(
        "was chosen. On takes it had not seen it was"
    )
    expect(page.locator("#notice")).to_contain_text("“calm-auto” is ready to play.")
    page.screenshot(path=pictures / "chosen.png")
    page.reload()
    expect(page.locator("#fit-report")).to_contain_text("was chosen.")
