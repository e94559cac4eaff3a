"""What plays is asked why, corrected, taken over from, and followed to where it fails."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

from evastudio.demonstrations.records import RECORDED
from evastudio.demonstrations.store import Store
from evastudio.live import headless
from tests.browser.acting import FRAMES, at_least, focus_view, moment, phase
from tests.browser.axe import barriers

if TYPE_CHECKING:
    from conftest import Open, Running

FIELD = {"density": 1.0}
JOB_MS = 240_000
"""A job gives way to everything else on the machine."""


def test_what_plays_is_asked_why_and_taught_better(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    workspace = studio.workspace
    headless.record(workspace, "asteroids", minutes=0.6, seed=3, options=FIELD, session="Shown")
    headless.fit(workspace, "Shown", learner="knn", delay="off", name="own")
    page.set_viewport_size({"width": 1180, "height": 720})
    stage = open_page(studio).stage
    page.locator("#option-density").fill("0.1")
    page.locator("#policy").select_option("own")
    page.locator("#play").click()
    phase(page, "playing")

    # How familiar it is, while it plays.
    at_least(page, "seconds", 2)
    expect(page.locator("#gauge-fill")).to_be_visible()
    expect(page.locator("#gauge-says")).to_contain_text("your takes")

    # A click into the view holds it still, and tells which moments the decision came from.
    focus_view(page)
    phase(page, "paused")
    rows = page.locator("#why-moments > li")
    why = stage.correcting.why()
    assert why is not None
    assert why.moments is not None
    expect(rows).to_have_count(len(why.moments))
    take, step = why.moments[0].tolist()
    expect(rows.first).to_have_attribute("data-take", str(take))
    expect(rows.first).to_have_attribute("data-step", str(step))
    assert barriers(page) == []
    page.evaluate(FRAMES, 20)
    page.screenshot(path=pictures / "why.png")

    # One is looked at in its take, and one is back where one was.
    stood = stage.status()["seconds"]
    rows.first.locator("[data-does=look]").click()
    phase(page, "reviewing")
    moment(page, stage, step * stage.scene.dt_s)
    assert stage.status()["take"] == take
    expect(rows.first).to_have_class("here")
    page.locator("#why-back").click()
    phase(page, "paused")
    assert stage.status()["seconds"] == stood

    # One is left out: the decision comes from others at once, and fits do without it.
    rows.first.locator("[data-does=forget]").click()
    second = why.moments[1].tolist()
    expect(rows.first).to_have_attribute("data-step", str(second[1]))
    after = stage.correcting.why()
    assert after is not None
    assert after.moments is not None
    assert [take, step] not in after.moments.tolist()
    expect(page.locator("#unclean")).to_have_attribute("aria-disabled", "false")
    with Store(workspace.store_url) as store:
        session = store.session("Shown").id
        assert store.marks(session)[take][step]
        before = store.session("Shown").takes_kept

    # Whoever steers takes over; T hands back. What was steered is a correction in the store.
    page.keyboard.press("Space")
    phase(page, "playing")
    expect(page.locator("#why")).to_be_hidden()
    page.keyboard.down("a")
    phase(page, "recording")
    expect(page.locator("#phase")).to_have_text("You steer instead of own")
    at_least(page, "pairs", 8)
    page.keyboard.press("t")
    page.keyboard.up("a")
    phase(page, "playing")
    at_least(page, "takes-kept", before + 1)
    with Store(workspace.store_url) as store:
        correction = store.takes(session)[-1]
        data = store.load_take(correction.id)
    assert correction.origin is not None
    assert correction.origin.policy == "own"
    assert correction.pairs >= 8
    assert abs(data.actions[:, 0]).max() > 0.0
    page.keyboard.press("Space")
    phase(page, "paused")
    expect(page.locator("#strip .mark.hand").first).to_be_attached()
    page.keyboard.press("Escape")
    phase(page, "ready")

    # Failures are found without a screen, and gone to before they happen.
    page.locator("#option-density").fill("4")
    page.keyboard.press("g")
    expect(page.locator("#failures > li").first).to_be_visible(timeout=JOB_MS)
    phase(page, "paused")
    expect(page.locator("#fails-says")).to_contain_text("worlds")
    expect(page.locator("#placed")).to_contain_text("3 s from here")
    page.evaluate(FRAMES, 20)
    page.screenshot(path=pictures / "failures.png")
    status = stage.status()
    page.keyboard.down("d")
    phase(page, "recording")
    at_least(page, "pairs", 3)
    page.keyboard.up("d")
    page.keyboard.press("Escape")
    phase(page, "ready")
    at_least(page, "takes-kept", before + 2)
    with Store(workspace.store_url) as store:
        origin = store.takes(session)[-1].origin
    assert origin is not None
    assert (origin.policy, origin.seed) == ("own", status["seed"])
    assert abs(origin.step * stage.scene.dt_s - status["seconds"]) < 1e-6

    # A take begins where none has been.
    page.keyboard.press("o")
    expect(page.locator("#phase[data-phase=countdown]")).to_be_attached(timeout=JOB_MS)
    phase(page, "recording")
    at_least(page, "pairs", 5)
    page.keyboard.press("Escape")
    phase(page, "ready")
    at_least(page, "takes-kept", before + 3)
    with Store(workspace.store_url) as store:
        visit = store.takes(session)[-1]
    assert visit.origin is not None
    assert (visit.seed, visit.origin.take is not None) == (RECORDED, True)

    # Of a policy without its moments it is said why nothing is shown.
    page.locator("#policy").select_option("asteroids-careful")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 1)
    expect(page.locator("#phase")).to_have_text("Playing asteroids-careful")
    page.keyboard.press("y")
    phase(page, "paused")
    expect(page.locator("#why-says")).to_contain_text("compact form")
    expect(page.locator("#why-moments")).to_be_hidden()
    expect(page.locator("#gauge-says")).to_have_text("Cannot tell how like your takes")


def test_in_a_small_window_nothing_lies_over_another(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    workspace = studio.workspace
    headless.record(workspace, "asteroids", minutes=0.6, seed=3, options=FIELD, session="Shown")
    headless.fit(workspace, "Shown", learner="knn", delay="off", name="own")
    page.set_viewport_size({"width": 900, "height": 477})
    stage = open_page(studio).stage
    page.locator("#option-density").fill("0.1")
    page.locator("#policy").select_option("own")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 1)
    stage.pause()
    phase(page, "paused")
    expect(page.locator("#why-moments > li")).not_to_have_count(0)
    assert apart(page, "#why-says", "#why-moments > li:first-child")
    page.screenshot(path=pictures / "small-why.png")
    page.locator("#why-close").click()
    expect(page.locator("#paused")).to_be_visible()
    assert apart(page, "#paused", "#tools")
    page.screenshot(path=pictures / "small-paused.png")
    page.keyboard.press("Space")
    phase(page, "playing")
    page.keyboard.down("a")
    phase(page, "recording")
    assert apart(page, "#pad", "#gauge")
    page.screenshot(path=pictures / "small-steering.png")
    page.keyboard.up("a")


def apart(page: Page, one: str, other: str) -> bool:
    """Whether two that are shown do not overlap."""
    first, second = (page.locator(where).bounding_box() for where in (one, other))
    assert first is not None, one
    assert second is not None, other
    return (
        first["x"] + first["width"] <= second["x"]
        or second["x"] + second["width"] <= first["x"]
        or first["y"] + first["height"] <= second["y"]
        or second["y"] + second["height"] <= first["y"]
    )
