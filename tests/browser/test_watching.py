"""A viewer's page, in real Chromium: what an author does is seen, and nothing can be done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Role, Tokens
from tests.browser.acting import phase

if TYPE_CHECKING:
    from conftest import Running

API = "/api/v1"


def test_a_viewer_watches_and_changes_nothing(
    page: Page, run_studio: Callable[[], Running], pictures: Path
) -> None:
    studio = run_studio()
    base, _, token = studio.url.partition("/?token=")
    with Store(studio.workspace.store_url) as store:
        viewer = Tokens(store).add("Vera", Role.VIEWER, 0.0)
    author = httpx.Client(
        base_url=base, headers={"Authorization": f"Bearer {token}"}, trust_env=False, timeout=30.0
    )
    refusals: list[int] = []
    page.on("response", lambda answer: answer.status >= 400 and refusals.append(answer.status))
    page.goto(f"{base}/?token={viewer}")
    expect(page.locator("#connection")).to_contain_text("Nobody has a stage open")
    assert page.locator("main button, .session button").count() == 0

    with author:
        stage = author.post(f"{API}/stages", json={"scene": "asteroids", "seed": 6}).json()
        element = page.wait_for_selector("#view[src]")
        assert element is not None
        frame = element.content_frame()
        assert frame is not None
        frame.wait_for_selector("canvas")
        expect(page.locator("#watched")).to_contain_text("stage 1")
        page.locator("#view").focus()
        for key in ("w", "Space", "r", "Backspace", "u", "c"):
            page.keyboard.press(key)
        phase(page, "ready")
        command = {"name": "play", "policy": "straight"}
        author.post(f"{API}/stages/{stage['id']}/commands", json=command)
        phase(page, "playing")
        page.screenshot(path=pictures / "watching.png")
        page.wait_for_function("Number(document.getElementById('seconds').textContent) > 0.5")
        author.delete(f"{API}/stages/{stage['id']}")
        expect(page.locator("#connection")).to_contain_text("Nobody has a stage open")
    assert [code for code in refusals if code != 404] == []

    page.goto(f"{base}/compare")
    expect(page.locator("p.viewer")).to_be_visible()
    expect(page.locator("#evaluate")).to_be_hidden()
    expect(page.locator("#again")).to_be_hidden()
    expect(page.locator("#notice .error")).to_have_count(0)
