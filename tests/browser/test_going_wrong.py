"""A take that goes wrong is kept, and the page says what that means; what else it says plainly."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from tests.browser.acting import at_least, focus_view, phase

if TYPE_CHECKING:
    from conftest import Open


def test_who_crashes_is_told_that_it_is_kept_and_how_to_throw_it_away(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    page.set_viewport_size({"width": 1280, "height": 720})
    studio = open_page().studio
    page.locator("#option-density").fill("10")
    page.locator("#tour-go").click()
    page.locator("#demonstrate").click()
    phase(page, "recording")
    focus_view(page)
    page.keyboard.down("ArrowUp")
    at_least(page, "pairs", 6)
    page.keyboard.up("ArrowUp")
    expect(page.locator("#outcome[data-success=false]")).to_be_visible()
    expect(page.locator("#ending-hint")).to_contain_text(
        "kept, though it went wrong: what led to that may be learned too. R starts another take, "
        "Backspace throws this one away."
    )
    expect(page.locator("#tour-says")).to_contain_text("That take went wrong and is kept")
    page.screenshot(path=pictures / "went-wrong.png")
    expect(page.locator("#late")).to_have_attribute("title", re.compile("after their time"))
    expect(page.locator("#late")).to_have_text(re.compile(r"^(\d+ of \d+ steps late)?$"))

    page.keyboard.press("Backspace")
    expect(page.locator("#takes-kept")).to_have_text("0")
    expect(page.locator("#tour-says")).not_to_contain_text("went wrong")
    with Store(studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id, trashed=True)
    assert take.outcome in {"hit", "left"}
