"""What the pages look like, in real Chromium: light and dark, by keys alone, at any size."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from matplotlib.image import imread
from playwright.sync_api import Browser, Page, expect

from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.live.tokens import Role, Tokens
from evastudio.workspace import Workspace
from tests.browser.acting import FRAMES, phase, until
from tests.browser.axe import barriers

if TYPE_CHECKING:
    from conftest import Open, Running

FIELD = {"density": 1.0}
UNFOLD = "() => document.querySelectorAll('details').forEach(one => (one.open = true))"
CONTROLS = """async () => {
  const {WITHOUT} = await import("/web/js/shortcuts.js");
  const which = "button, a[href], input, select, textarea, summary, iframe";
  return [...document.querySelectorAll(which)].flatMap(one => {
    const told = one.title || one.closest("label[title], fieldset[title]")?.title ||
      one.parentElement.closest(".option[title]")?.title;
    const keyed = one.hasAttribute("aria-keyshortcuts") ||
      WITHOUT.some(([selector]) => one.matches(selector));
    const lacks = [told ? "" : "a tooltip", keyed ? "" : "a key or a reason"].filter(Boolean);
    return lacks.length ? [`${one.id || one.outerHTML.slice(0, 120)} lacks ${lacks}`] : [];
  });
}"""
"""Every control that says nothing of itself, or has no key and no reason for it."""
CLASHES = """async () => {
  const {STUDIO, WATCHING, COMPARING, VOTING} = await import("/web/js/shortcuts.js");
  return [STUDIO, WATCHING, COMPARING, VOTING].flatMap(groups => {
    const always = groups.flatMap(({shortcuts}) => shortcuts).filter(({when}) => !when);
    const keys = always.flatMap(({keys}) => keys);
    return keys.filter((key, i) => keys.indexOf(key) !== i);
  });
}"""
JUMPS = """() => {
  window.jumps = [];
  new PerformanceObserver(list => {
    for (const {value, hadRecentInput, sources} of list.getEntries()) {
      if (!hadRecentInput) {
        const what = sources.map(({node}) => node?.id || node?.className || node?.nodeName);
        window.jumps.push([value, what.join(" ")]);
      }
    }
  }).observe({type: "layout-shift", buffered: true});
}"""


def made(workspace: Workspace) -> str:
    """A session with a take and a policy from it; a viewer's token."""
    headless.record(workspace, "asteroids", minutes=0.4, seed=3, options=FIELD, session="Shown")
    headless.fit(workspace, "Shown", learner="knn", delay="off", name="own")
    with Store(workspace.store_url) as store:
        return Tokens(store).add("Vera", Role.VIEWER, 0.0)


def brightness(page: Page) -> float:
    """Of what is seen in the middle of the 3D view, 0 to 1."""
    drawn = imread(io.BytesIO(page.locator("#view").screenshot()))
    height, width = drawn.shape[:2]
    return float(np.mean(drawn[height // 4 : height // 2, width // 4 : -width // 4, :3]))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_keeps_anybody_out(
    scheme: Any,
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    browser: Browser,
    pictures: Path,
) -> None:
    studio = run_studio()
    viewer = made(studio.workspace)
    base = studio.url.partition("/?")[0]
    page.emulate_media(color_scheme=scheme)
    found: dict[str, list[Any]] = {}

    page.goto(f"{base}/")
    expect(page.locator("h1")).to_have_text("No access")
    found["no access"] = barriers(page)

    # The studio, all that folds opened, with the tour's card, the sheet and the timeline.
    opened = open_page(studio)
    page.keyboard.press("h")
    expect(page.locator("#tour")).to_be_visible()
    page.evaluate(UNFOLD)
    page.locator("#new-session").click()
    found["studio"] = barriers(page)
    found["view"] = barriers(opened.view)
    found["studio's controls"] = page.evaluate(CONTROLS)
    page.keyboard.press("Escape")
    page.locator("#tour-end").click()
    page.keyboard.press("?")
    expect(page.locator("#sheet")).to_be_visible()
    found["sheet"] = barriers(page)
    page.set_viewport_size({"width": 1280, "height": 800})
    if scheme == "light":
        page.screenshot(path=pictures / "keys.png")
    page.keyboard.press("Escape")
    page.locator("#takes .thumbnail").first.click()
    expect(page.locator("#timeline")).to_be_visible()
    found["timeline"] = barriers(page)
    found["timeline's controls"] = page.evaluate(CONTROLS)
    found["keys that clash"] = page.evaluate(CLASHES)

    page.goto(f"{base}/compare")
    expect(page.locator("#pilots input").first).to_be_visible()
    page.evaluate(UNFOLD)
    found["compare"] = barriers(page)
    found["compare's controls"] = page.evaluate(CONTROLS)

    page.goto(f"{base}/vote")
    expect(page.locator("#sheet-open[aria-keyshortcuts]")).to_be_visible()
    found["vote"] = barriers(page)
    found["vote's controls"] = page.evaluate(CONTROLS)

    with browser.new_context(color_scheme=scheme, reduced_motion="reduce") as other:
        watching = other.new_page()
        watching.goto(f"{base}/?token={viewer}")
        expect(watching.locator("#panel")).to_contain_text("You came in to watch")
        expect(watching.locator("#sheet-open[aria-keyshortcuts]")).to_be_visible()
        found["watch"] = barriers(watching)
        found["watch's controls"] = watching.evaluate(CONTROLS)
    assert {name: one for name, one in found.items() if one} == {}


def test_what_is_chosen_is_remembered_and_the_view_goes_along(
    page: Page, open_page: Callable[[], Open]
) -> None:
    open_page()
    html = page.locator("html")
    expect(html).to_have_attribute("data-scheme", "dark")
    until(page, lambda: brightness(page) < 0.45)
    page.locator("#tour-end").click()
    page.keyboard.press("Shift+L")
    expect(html).to_have_attribute("data-scheme", "light")
    frame = page.wait_for_selector("#view[src$='/light/']").content_frame()
    assert frame is not None
    frame.wait_for_selector("canvas")
    until(page, lambda: brightness(page) > 0.55)

    page.reload()
    expect(html).to_have_attribute("data-scheme", "light")
    page.locator("#scheme").click()
    expect(html).to_have_attribute("data-scheme", "dark")
    page.emulate_media(color_scheme="light")  # whoever came back to it follows the browser again
    expect(html).to_have_attribute("data-scheme", "light")


def test_it_fits_from_a_tablet_to_a_large_screen(
    page: Page, open_page: Callable[[], Open], browser: Browser
) -> None:
    opened = open_page()
    page.locator("#tour-end").click()
    for width, height, font in [
        (1180, 820, 15),
        (1280, 720, 15),
        (1920, 1080, 15),
        (3840, 2160, 24),
    ]:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(FRAMES, 2)
        assert page.evaluate("document.documentElement.scrollWidth") == width
        assert page.evaluate("document.documentElement.scrollHeight") == height
        size = page.evaluate("getComputedStyle(document.documentElement).fontSize")
        assert float(size.removesuffix("px")) == pytest.approx(font, abs=0.1)
        for step in ("demonstrate", "clean", "fit", "play"):
            box = page.locator(f"#{step}").bounding_box()
            assert box is not None
            assert box["y"] + box["height"] <= height, f"{step} is out of sight at {width}x{height}"

    page.goto("about:blank")  # so large a view takes all that the machine has

    # A finger hits everything on an upright tablet, and the page only scrolls down.
    tablet = browser.new_context(
        viewport={"width": 820, "height": 1180}, has_touch=True, is_mobile=True
    )
    with tablet:
        touched = tablet.new_page()
        touched.goto(opened.studio.url)
        expect(touched.locator("#camera")).to_contain_text("chase")
        small = touched.evaluate("""() =>
          [...document.querySelectorAll("#panel :is(button, summary, select), .tools button")]
            .filter(one => one.checkVisibility())
            .map(one => [one.id || one.textContent, one.getBoundingClientRect()])
            .filter(([, {width, height}]) => Math.min(width, height) < 40)
            .map(([name, {width, height}]) => `${name} ${width}x${height}`)""")
        assert small == []
        assert touched.evaluate("document.documentElement.scrollWidth") == 820


def test_nothing_jumps_and_nothing_fails_while_one_works(
    page: Page, run_studio: Callable[[], Running], open_page: Callable[[Running], Open]
) -> None:
    studio = run_studio()
    made(studio.workspace)
    said: list[str] = []
    page.on(
        "console", lambda one: one.type == "error" and said.append(f"{one.text} {one.location}")
    )
    opened = open_page(studio)
    page.locator("#option-density").fill("0")
    page.evaluate(JUMPS)
    page.locator("#demonstrate").click()
    page.wait_for_function("() => Number(document.getElementById('pairs').textContent) >= 12")
    page.keyboard.press("Space")
    phase(page, "paused")
    page.keyboard.press("Escape")
    phase(page, "ready")
    for kind in ("clean", "fit"):  # the work takes the place of what the step says
        page.locator(f"#{kind}").click()
        work = page.locator(f".job[data-kind={kind}]")
        expect(work).to_be_visible()
        work.locator("button").click()
        expect(work).to_be_hidden()
    page.locator("#play").click()
    phase(page, "playing")
    page.wait_for_function("() => Number(document.getElementById('seconds').textContent) >= 1")
    page.keyboard.press("Escape")
    phase(page, "ready")
    jumps = page.evaluate("window.jumps")
    told = "; ".join(f"{value:.4f} {what}" for value, what in jumps)
    assert sum(value for value, _ in jumps) < 0.02, told
    assert opened.stage.status()["takes_kept"] == 2
    assert said == []
