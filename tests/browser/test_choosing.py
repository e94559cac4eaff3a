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
    page.locator("#option-density").fill("0.8")
    page.reload()
    expect(page.locator("#fit-report")).to_contain_text("was chosen.")
    expect(page.locator("#option-density")).to_have_value("0.8")

    # Fitted again from more takes: both policies are there, and what is old is said to be.
    page.locator("label:has(input[name=learner][value=knn])").click()
    page.locator("#fit").click()
    expect(page.locator("#policy")).to_have_value("calm-knn")
    (take, *_) = studio.context.store.takes(1)
    studio.context.store.trash_take(take.id, 1.0)
    page.reload()
    expect(page.locator("#fit-more summary")).to_have_text("All that the fit before found")
    expect(page.locator("#fit-report")).to_be_empty()
    page.locator("label:has(input[name=learner][value=knn])").click()
    page.locator("#fit").click()
    expect(page.locator("#policy")).to_have_value("calm-knn-2")
    expect(page.locator("#policy option[value=calm-knn]")).to_be_attached()
    page.goto(page.url.rstrip("/") + "/compare")
    expect(page.locator("#option-density")).to_have_value("0.8")
