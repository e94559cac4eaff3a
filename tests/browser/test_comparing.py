"""Comparing, in real Chromium: choose, evaluate, read, open again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

if TYPE_CHECKING:
    from conftest import Running


def enter(page: Page, studio: Running) -> list[str]:
    """Open the page that compares; what the browser's console says against it from then on."""
    said: list[str] = []
    page.on("console", lambda message: message.type == "error" and said.append(message.text))
    base = studio.url.partition("/?")[0]
    page.context.request.get(studio.url)  # leaves the cookie that the printed address gives
    page.goto(f"{base}/compare")
    return said


def test_a_designer_compares_and_opens_it_again(
    page: Page, run_studio: Callable[[], Running], pictures: Path
) -> None:
    page.set_viewport_size({"width": 1280, "height": 1000})
    said = enter(page, run_studio())
    expect(page.locator("#empty")).to_contain_text("Choose two or more")
    page.locator("#evaluate").click(force=True)
    expect(page.locator("#notice")).to_contain_text("Choose two or more to compare.")

    # By the keyboard alone.
    careful = page.get_by_label("asteroids-careful")
    careful.focus()
    page.keyboard.press("Space")
    expect(page.locator("#evaluate-says")).to_have_text("Choose one more to compare with.")
    programs = page.locator("#pilots summary")
    programs.focus()
    page.keyboard.press("Enter")
    page.get_by_label("straight", exact=True).focus()
    page.keyboard.press("Space")
    page.locator("#worlds").fill("40")
    expect(page.locator("#evaluate-says")).to_have_text("2 pilots through the same 40 worlds.")
    page.keyboard.press("Enter")

    # People can be asked, but not those elsewhere while the studio listens to this machine alone.
    page.locator("#ask-people").click()
    expect(page.locator("#notice")).to_contain_text("Only this computer can open such a link")
    expect(page.locator("#ballots-say")).to_contain_text("start the studio with --host 0.0.0.0")

    expect(page.locator("#found-title")).to_have_text(
        "asteroids-careful, straight in the same 40 worlds"
    )
    expect(page.locator("#words")).to_contain_text(
        "asteroids-careful ends well more often than straight"
    )
    expect(page.locator("#table tbody tr").first).to_contain_text("Worlds ended well, %100")
    drawn = page.locator("#pictures figure img")
    expect(drawn).to_have_count(4)
    loaded = "image => image.decode().then(() => image.naturalWidth)"
    assert all(drawn.nth(i).evaluate(loaded) > 100 for i in range(4))
    page.screenshot(path=pictures / "compare.png")

    # At another density: the two evaluations become a curve.
    page.locator("#option-density").fill("1")
    page.locator("#evaluate").click()
    expect(page.locator("#found-asked")).to_contain_text("rocks in the way 1")
    expect(page.locator("figure[data-picture=crossing] img")).to_be_visible()

    page.locator("#again").click()
    expect(page.locator("#notice")).to_contain_text("came out the same again, in every world")

    page.goto(page.url.partition("#")[0])
    expect(page.locator("#earlier a").first).to_contain_text("rocks in the way 1")
    page.locator("#earlier a").last.click()
    expect(page.locator("#found-title")).to_contain_text("in the same 40 worlds")
    expect(drawn).to_have_count(5)
    page.locator("#scene").select_option("crowd")
    expect(page.locator("#earlier-says")).to_have_text("Evaluations are kept here.")
    expect(page.get_by_label("crowd-shy")).to_be_visible()
    assert said == []
