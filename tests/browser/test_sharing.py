"""A picture of the view and a page that plays a run, as real Chromium shows and opens them."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import av
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Browser, Page, Request, expect

from evastudio.studio.painter import Painter
from tests.browser.acting import FRAMES, at_least, camera, focus_view, moment, phase
from tests.browser.conftest import WAIT_MS

if TYPE_CHECKING:
    from conftest import Open

SHOWN = """() => {
  const canvas = document.querySelector("canvas[data-engine]");
  return canvas ? canvas.toDataURL("image/png").length : 0;
}"""


def picture(data: bytes) -> NDArray[np.uint8]:
    with av.open(io.BytesIO(data)) as container:
        return next(container.decode(video=0)).to_ndarray(format="rgb24")


def test_what_is_seen_is_handed_out_and_plays_with_no_network(
    page: Page, browser: Browser, open_page: Callable[[], Open], tmp_path: Path, pictures: Path
) -> None:
    opened = open_page()
    studio, stage = opened.studio, opened.stage
    page.locator("#option-density").fill("0.5")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 1)
    page.keyboard.press("l")
    phase(page, "reviewing")
    focus_view(page)
    page.keyboard.press("Home")
    moment(page, stage, 0.0)
    seen_from = stage.scene.camera(stage.snapshot)
    camera(studio, opened.view, near=seen_from.position)
    opened.view.evaluate(FRAMES, 4)

    # The picture is the view, and the painter, who needs no browser, paints the same.
    with page.expect_download() as download:
        page.keyboard.press("p")
    assert download.value.suggested_filename.startswith("asteroids-")
    seen = picture(download.value.path().read_bytes()).astype(int)
    height, width, _ = seen.shape
    assert opened.view.evaluate("document.querySelector('canvas[data-engine]').width") == width
    assert seen.std() > 10.0
    painter = Painter(stage.scene, width, height)
    painted = painter.paint(stage.snapshot, seen_from).astype(int)
    apart = np.abs(seen - painted).mean()
    assert apart < 3.0
    assert np.abs(seen[:, ::-1] - painted).mean() > 3.0 * apart
    assert np.abs(seen[::-1] - painted).mean() > 3.0 * apart

    assert page.evaluate("document.scrollingElement.scrollHeight <= innerHeight")
    page.locator("#share > summary").click()
    page.screenshot(path=pictures / "sharing.png")
    with page.expect_download() as download:
        page.locator("#share button[data-form=html]").click()
    name = download.value.suggested_filename
    assert [path.name for path in studio.workspace.films.iterdir()] == [name]
    saved = tmp_path / name
    download.value.save_as(saved)
    expect(page.locator("#notice")).to_contain_text("is made")
    menu = page.locator("#share > .share-menu")
    expect(menu).to_be_hidden()

    # Esc folds it up before it leaves, and who leaves finds it folded up the next time.
    page.locator("#share > summary").click()
    expect(menu).to_be_visible()
    page.keyboard.press("Escape")
    expect(menu).to_be_hidden()
    phase(page, "reviewing")
    page.locator("#share > summary").click()
    page.locator("#looking-back [data-does=leave]").click()
    phase(page, "paused")
    expect(menu).to_be_hidden()
    page.keyboard.press("l")
    phase(page, "reviewing")
    expect(menu).to_be_hidden()

    # It plays from a file, and asks nobody for anything.
    context = browser.new_context(viewport={"width": 640, "height": 400})
    context.set_default_timeout(WAIT_MS)
    alone, asked = context.new_page(), list[str]()
    thrown: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url)

    alone.on("request", note)
    alone.on("websocket", lambda socket: asked.append(socket.url))
    alone.on("pageerror", lambda error: thrown.append(str(error)))
    alone.goto(saved.as_uri())
    alone.wait_for_selector("canvas[data-engine]")
    first = alone.evaluate(SHOWN)
    alone.wait_for_function(f"before => ({SHOWN})() !== before && ({SHOWN})() > 20000", arg=first)
    then = alone.evaluate(SHOWN)
    alone.wait_for_function(f"before => ({SHOWN})() !== before", arg=then)
    context.close()
    assert [url for url in asked if not url.startswith(("file:", "blob:", "data:"))] == []
    assert thrown == []
