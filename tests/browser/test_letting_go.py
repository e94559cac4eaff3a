"""Whatever takes the keyboard away in the middle of a hold, the key is released and the take whole.

The key itself stays down all the while, as a finger does that knows nothing of it.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import Page, Playwright, expect

from tests.browser.acting import focus_view, phase
from tests.browser.conftest import FLAGS, WAIT_MS
from tests.browser.organist import sit_down
from tests.scenes.organ import CODES

if TYPE_CHECKING:
    from conftest import Running

SILENT_STEPS = 30
"""A page that is silent for so many steps was silent for longer than its word is good."""


def socket_of(studio: Running) -> Any:
    """uvicorn's end of the stage's websocket."""
    (found,) = (
        one
        for one in studio.server.server_state.connections
        if (getattr(one, "scope", None) or {}).get("path", "").endswith("/socket")
    )
    return found


def test_focus_and_connection_are_lost_in_the_middle_of_a_hold(
    page: Page, run_studio: Callable[[], Running]
) -> None:
    organist = sit_down(page, run_studio())
    a, s, d = (CODES.index(code) for code in ("KeyA", "KeyS", "KeyD"))

    # Another window takes the focus. (Playwright lets pages believe that they have it.)
    pretending = page.context.new_cdp_session(page)
    pretending.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    page.bring_to_front()
    page.keyboard.down("KeyA")
    held = organist.holds("KeyA")
    organist.rest(3)
    other = page.context.new_page()
    other.bring_to_front()
    lost = organist.holds()
    end_lost = organist.rest(3)
    page.bring_to_front()
    page.keyboard.up("KeyA")

    # The network fails without a word, and comes back.
    focus_view(page)
    page.keyboard.down("KeyS")
    organist.holds("KeyS")
    wire = socket_of(organist.studio)
    wire.loop.call_soon_threadsafe(wire.transport.pause_reading)
    silent = organist.pairs()
    organist.until(lambda: organist.pairs() >= silent + SILENT_STEPS)
    end_silent = organist.pairs()
    wire.loop.call_soon_threadsafe(wire.transport.resume_reading)
    back = organist.holds("KeyS")
    end_back = organist.rest(2)
    page.keyboard.up("KeyS")
    organist.holds()

    # The connection breaks: the take pauses, and goes on when the person says so.
    page.keyboard.down("KeyD")
    organist.holds("KeyD")
    organist.rest(3)
    wire.loop.call_soon_threadsafe(wire.transport.abort)
    phase(page, "paused")
    expect(page.locator("#connection")).to_be_hidden()
    broken = organist.pairs()
    focus_view(page)
    page.keyboard.press("Space")
    phase(page, "recording")
    organist.until(lambda: organist.pairs() >= broken + 4)
    page.keyboard.up("KeyD")

    actions = organist.finish()
    assert (actions[held + 1 : held + 3, a] == 1.0).all()
    assert (actions[lost + 1 : end_lost, a] == 0.0).all()
    assert actions[silent - 1 : silent + 2, s].all()
    assert (actions[end_silent - 5 : end_silent, s] == 0.0).all()
    assert (actions[back + 1 : end_back, s] == 1.0).all()
    assert actions[broken - 2, d] == 1.0
    assert (actions[broken:, d] == 0.0).all()
    assert len(actions) >= broken + 4


@pytest.fixture
def plain_page(playwright: Playwright, tmp_path: Path) -> Iterator[Page]:
    """A page of a Chromium that hides what is hidden, which Playwright keeps its own from."""
    chromium = shutil.which("chromium") or playwright.chromium.executable_path
    process = subprocess.Popen(
        [
            *(chromium, "--headless", *FLAGS),
            *("--remote-debugging-port=0", f"--user-data-dir={tmp_path / 'profile'}"),
        ],
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    with process.stderr as told:
        address = next(line.split()[-1] for line in told if "DevTools listening" in line)
        browser = playwright.chromium.connect_over_cdp(address, no_defaults=True)
        page = browser.contexts[0].pages[0]
        page.set_default_timeout(WAIT_MS)
        yield page
        browser.new_browser_cdp_session().send("Browser.close")
        process.wait(30)


def test_the_tab_is_hidden_in_the_middle_of_a_hold(
    plain_page: Page, run_studio: Callable[[], Running]
) -> None:
    page = plain_page
    organist = sit_down(page, run_studio())
    page.keyboard.down("KeyA")
    held = organist.holds("KeyA")
    organist.rest(3)
    other = page.context.new_page()
    other.bring_to_front()
    hidden = organist.holds()
    assert page.evaluate("document.hidden")
    end = organist.rest(3)
    page.bring_to_front()
    page.keyboard.up("KeyA")
    phase(page, "recording")
    actions = organist.finish()
    a = CODES.index("KeyA")
    assert (actions[held + 1 : held + 3, a] == 1.0).all()
    assert (actions[hidden + 1 : end, a] == 0.0).all()
