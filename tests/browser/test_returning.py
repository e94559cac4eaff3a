"""A studio that is started anew, in real Chromium: the page goes back to where one was."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from playwright.sync_api import Page, expect

from evastudio.live import headless
from evastudio.workspace import Workspace
from tests.conftest import launch

if TYPE_CHECKING:
    from pathlib import Path


def test_a_page_is_where_it_was_after_a_restart(page: Page, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "work").ready()
    for name in ("First", "Second"):
        headless.record(workspace, "asteroids", minutes=0.2, seed=3, session=name)
    studio = launch(workspace)
    port = urlsplit(studio.base).port
    page.goto(studio.url)
    expect(page.locator("#phase[data-phase=ready]")).to_be_attached()
    page.locator("#session").select_option(label="First (1 take)")
    expect(page.locator("#takes > li")).to_have_attribute("data-take", "1")
    expect(page.locator("#session option:checked")).to_have_text("First (1 take)")
    page.locator("#option-density").fill("2")
    page.locator("#camera").click()
    expect(page.locator("#camera")).not_to_contain_text("chase")
    camera = page.locator("#camera").inner_text()
    page.locator("#takes-box summary").click()
    page.locator("#takes .thumbnail").first.click()
    expect(page.locator("#phase")).to_have_text("Looking at take 1")
    page.keyboard.press("K")
    page.keyboard.press("End")
    time = page.locator("#moment-time")
    page.wait_for_function("() => document.getElementById('moment').valueAsNumber > 60")
    shown = time.inner_text()

    expect(page.locator("#session option:checked")).to_have_text("First (1 take)")
    studio.kill()
    studio.client.close()
    assert studio.process.stdout is not None
    studio.process.stdout.close()
    expect(page.locator("#connection")).to_contain_text("The studio does not answer")
    again = launch(workspace, arguments=["--port", str(port)])
    try:
        expect(page.locator("#connection")).to_be_hidden()
        expect(page.locator("#phase")).to_have_text("Looking at take 1")
        expect(time).to_have_text(shown)
        expect(page.locator("#camera")).to_have_text(camera, use_inner_text=True)
        expect(page.locator("#session option:checked")).to_have_text("First (1 take)")
        expect(page.locator("#option-density")).to_have_value("2")
    finally:
        again.stop()
