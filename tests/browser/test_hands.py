"""A mouse as a stick, a gamepad, slow motion, and takes that follow one another, in Chromium."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from tests.browser.acting import at_least, phase

if TYPE_CHECKING:
    from conftest import Open

GAMEPAD = """() => {
  const button = () => ({ pressed: false, touched: false, value: 0 });
  window.pad = { id: "Stub Pad (Vendor: 0000)", index: 0, connected: true, mapping: "standard",
    axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, button) };
  window.plugged = [];
  navigator.getGamepads = () => window.plugged;
}"""
"""What a browser without a gamepad knows of gamepads, with one at hand."""


def plug_in(page: Page) -> None:
    page.evaluate(
        "window.plugged = [window.pad]; window.dispatchEvent(new Event('gamepadconnected'))"
    )


def pairs_more(page: Page, count: int) -> None:
    """Wait for that many more decisions."""
    at_least(page, "pairs", int(page.locator("#pairs").inner_text()) + count)


def dot(page: Page, x: str, y: str) -> None:
    """Wait until the pad's dot is there: such comparisons with its middle, 50."""
    page.wait_for_function(
        f"""() => {{
          const at = name => Number(document.querySelector("#pad .dot").getAttribute(name));
          return at("cx") {x} && at("cy") {y};
        }}"""
    )


def middle(page: Page, element: str) -> tuple[float, float]:
    box = page.locator(element).bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_mouse_and_gamepad_steer_in_slow_motion(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    page.add_init_script(f"({GAMEPAD})()")
    opened = open_page()
    studio, stage = opened.studio, opened.stage
    page.locator("#option-density").fill("0.1")
    page.locator("#steering > summary").click()
    page.locator("#sensitivity").fill("50")
    expect(page.locator("#sensitivity-is")).to_have_text("50 %")
    expect(page.locator("#pad")).to_be_hidden()
    for slower in ("75 %", "50 %", "25 %"):
        page.keyboard.press("-")
        expect(page.locator("#pace-is")).to_have_text(slower)

    page.locator("#demonstrate").click()
    phase(page, "recording")
    x, y = middle(page, "#pad")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 200, y, steps=4)
    dot(page, "> 65", "== 50")
    pairs_more(page, 4)
    page.screenshot(path=pictures / "hands.png")
    page.mouse.up()
    dot(page, "== 50", "== 50")

    plug_in(page)
    expect(page.locator("#gamepad")).to_have_text("Gamepad: Stub Pad")
    page.evaluate("window.pad.axes = [0, -1, 0, 0]")
    dot(page, "== 50", "< 35")
    pairs_more(page, 4)
    page.evaluate("window.pad.axes = [0.05, 0.05, 0, 0]")
    dot(page, "== 50", "== 50")

    # The view itself is the stick, and the camera keeps still.
    page.keyboard.press("i")
    x, y = middle(page, "#view")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 30, y + 300, steps=4)
    dot(page, "< 50", "> 60")
    pairs_more(page, 4)
    page.mouse.up()
    dot(page, "== 50", "== 50")

    # A button of the gamepad holds everything still.
    page.evaluate("window.pad.buttons[0].pressed = true")
    phase(page, "paused")
    page.locator("#stop").click()
    phase(page, "ready")
    at_least(page, "takes-kept", 1)
    assert stage.status()["pace"] == 0.25

    with Store(studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id)
        data = store.load_take(take.id)
    shares = data.actions / stage.scene.action.high
    right, up, down = (
        np.flatnonzero(found)
        for found in (shares[:, 0] == -0.5, shares[:, 1] == 0.5, shares[:, 1] < -0.4)
    )
    assert min(len(right), len(up), len(down)) >= 3
    assert right[-1] < up[0]
    assert up[-1] < down[0]
    assert not shares[right, 1].any()
    assert not shares[up, 0].any()
    assert 0.0 < shares[down, 0].max() < 0.1
    assert np.diff(data.snapshots["position"][:, 0]).max() <= 10 / 15 + 1e-9


def test_takes_follow_one_another_until_enough_are_kept(
    page: Page, open_page: Callable[[], Open], pictures: Path
) -> None:
    opened = open_page()
    page.locator("#option-density").fill("0.1")
    page.locator("#wanted").fill("1")
    page.locator("#wanted").blur()
    expect(page.locator("#rest")).to_be_hidden()
    page.keyboard.press("n")
    expect(page.locator("#automatic")).to_be_checked()
    page.locator("#rest").fill("1")
    page.locator("#rest").blur()
    expect(page.locator("#of-wanted")).to_have_text(" of 1")

    page.locator("#demonstrate").click()
    phase(page, "recording")
    at_least(page, "pairs", 5)
    page.keyboard.press("Backspace")
    expect(page.locator("#next-take")).to_be_visible()
    page.screenshot(path=pictures / "next-take.png")
    phase(page, "recording")
    expect(page.locator("#next-take")).to_be_hidden()
    page.locator("#keys select").select_option("2")
    at_least(page, "seconds", 2.5)
    page.keyboard.press("k")
    expect(page.locator("#takes-kept")).to_have_text("1")
    expect(page.locator("#of-wanted.reached")).to_have_text(" of 1")
    expect(page.locator("#notice")).to_contain_text("1 take kept, as many as you wanted")
    phase(page, "ready")
    assert opened.stage.status()["next_s"] is None

    with Store(opened.studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id)
    assert take.pairs == 30
