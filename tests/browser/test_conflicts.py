"""The review of conflicts, in real Chromium: seen, judged, cleaned, taken back; then fitted."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from playwright.sync_api import Page, expect

from evastudio.demonstrations.records import Verdict
from evastudio.demonstrations.store import Store
from evastudio.learning.policy_files import load_policy
from evastudio.live import headless
from evastudio.live.picture import Picture
from evastudio.live.weighing import weigh
from tests.browser.acting import FRAMES, at_least, camera, moment, phase

if TYPE_CHECKING:
    from conftest import Open, Running


def test_what_would_go_is_looked_at_judged_and_taken_back(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    made = {"seed": 7, "options": {"density": 3.0}, "session": "Shown"}
    headless.record(studio.workspace, "asteroids", "scripted:human", 1.0, **made)
    page.set_viewport_size({"width": 1180, "height": 720})
    opened = open_page(studio)
    stage = opened.stage
    store = Store(studio.workspace.store_url)
    session = store.session("Shown")
    expect(page.locator("#pairs-kept")).to_have_text("900")

    # One look, then any threshold at once, as the store has it.
    page.keyboard.press("x")
    says, rows = page.locator("#conflicts-says"), page.locator("#conflicts > li")
    expect(says).to_contain_text("would go")
    told = weigh(studio.workspace, store, session)
    expect(says).to_contain_text(f"{told.goes} of {told.pairs} pairs")
    expect(rows).to_have_count(told.conflicts)
    expect(rows.first).to_have_attribute("data-step", str(told.items[0].step))
    page.locator("#threshold").focus()
    page.keyboard.press("Home")
    expect(page.locator("#threshold-says")).to_have_text("2.0 %")
    strict = weigh(studio.workspace, store, session, 0.02)
    assert strict.goes > told.goes
    expect(says).to_contain_text(f"{strict.goes} of {told.pairs} pairs")
    page.locator("#threshold-auto").click()
    expect(rows).to_have_count(told.conflicts)
    expect(page.locator("#threshold-says")).to_have_text("is usual there")

    # Each is seen in the scene, with where its neighbours' actions lead.
    first, second, third, fourth, *_ = told.items
    shown: list[Picture] = []
    stage.watch(shown.append)
    rows.first.locator(".conflict").click()
    phase(page, "reviewing")
    moment(page, stage, first.seconds)
    camera(studio, opened.view, near=stage.scene.camera(stage.snapshot).position)
    ways = [line for line in shown[-1].lines if line.name.startswith("way")]
    assert len(ways) == told.neighbors + 1
    expect(rows.first.locator(".verdicts")).to_be_visible()
    row, why = (rows.first.locator(one).bounding_box() for one in (".conflict", ".contradiction"))
    assert row is not None
    assert why is not None
    assert row["y"] < why["y"] < row["y"] + row["height"]
    page.locator("#fit").scroll_into_view_if_needed()
    page.evaluate(FRAMES, 20)
    page.screenshot(path=pictures / "conflicts.png")

    # Judged by keys, one after the other.
    page.keyboard.press("Enter")
    moment(page, stage, second.seconds)
    page.keyboard.press("m")
    moment(page, stage, third.seconds)
    page.keyboard.press("Delete")
    expect(rows.nth(2)).to_have_attribute("data-verdict", "delete")
    expect(rows.first).to_have_attribute("data-verdict", "keep")
    expect(rows.first.locator(".said")).to_have_text("kept")
    said = {
        (first.take, first.step): Verdict.KEEP,
        (second.take, second.step): Verdict.MISSING,
        (third.take, third.step): Verdict.DELETE,
    }
    assert store.verdicts(session.id) == said
    expect(says).to_contain_text(f"{told.goes - 2} of {told.pairs} pairs")
    # A slip lasts some moments: the same is said of those around it at once.
    judged = page.locator(".conflicts li.shown")
    moment(page, stage, fourth.seconds)
    page.keyboard.press("ArrowUp")
    expect(judged).to_have_attribute("data-step", str(third.step))
    judged.locator("[data-does=around]").click()
    expect(judged.locator("[data-does=around]")).to_be_hidden()
    more = {(third.take, third.step + by): Verdict.DELETE for by in (-1, 1)}
    assert store.verdicts(session.id) == {**said, **more}
    goes = weigh(studio.workspace, store, session).goes
    page.keyboard.press("Escape")
    phase(page, "ready")

    # Cleaned as it was said, and taken back.
    page.locator("#clean").click()
    expect(page.locator("#clean-says")).to_contain_text(f"{goes} of {told.pairs} pairs taken out")
    marks = store.marks(session.id)
    assert not marks[first.take][first.step]
    assert marks[third.take][third.step]
    page.locator("#unclean").click()
    expect(page.locator("#unclean")).to_have_attribute("aria-disabled", "true")
    assert store.marks(session.id) == {}

    # Fitting can be ended.
    job = page.locator(".job[data-kind=fit]")
    page.locator("#learner label", has_text="Choose for me").click()
    page.locator("#fit").click()
    expect(job.locator("progress")).to_be_visible()
    job.get_by_text("Cancel").click()
    expect(job).to_be_hidden()
    assert list(studio.workspace.policies.glob("*.safetensors")) == []

    # What another perception shows is compared anew, and fitted.
    page.locator("#sees-box summary").click()
    page.locator("#sees").select_option("paper")
    expect(page.locator(".job[data-kind=preview]")).to_be_visible()
    expect(page.locator(".job[data-kind=preview]")).to_be_hidden()
    assert weigh(studio.workspace, store, session).perception == "paper"
    page.locator("#learner label", has_text="Exact").click()
    page.locator("#fit").click()
    expect(page.locator("#fit-report")).to_contain_text("you said that something is missing")
    expect(page.locator("#policy")).to_have_value("shown-knn-paper")
    made_of = load_policy(studio.workspace.policies / "shown-knn-paper.safetensors")
    assert made_of.perception == "paper"

    # What was made of other takes says so, in the list and where it plays.
    page.locator("#takes-box summary").click()
    page.locator("#takes [data-does=trash]").first.click()
    words = "made before 1 take was thrown away"
    expect(page.locator("#policy option:checked")).to_contain_text(words)
    expect(page.locator("#play-says")).to_contain_text(words)
    page.locator("#play").click()
    phase(page, "playing")
    expect(page.locator("#made-before")).to_have_text(words)
    store.close()


MUCH = """async () => {
  const {muchWords} = await import("/web/js/words.js");
  return [muchWords(16, 100, "auto"), muchWords(14, 100, "auto"), muchWords(16, 100, 0.1)];
}"""
"""What is said where much would go, and little, by itself, and much by a limit of one's own."""


def busy(progress: Any) -> dict[str, Any]:
    """Work that goes on until it is cancelled."""
    progress(0.1, "Drawing")
    while True:
        time.sleep(0.1)


def test_the_list_is_that_of_the_session_one_is_in(
    page: Page, run_studio: Callable[[], Running], open_page: Callable[[Running], Open]
) -> None:
    studio = run_studio()
    made = {"seed": 7, "options": {"density": 3.0}, "session": "Shown"}
    shown = headless.record(studio.workspace, "asteroids", "scripted:human", 0.5, **made)["session"]
    complaints: list[str] = []
    page.on("response", lambda one: complaints.append(one.url) if one.status >= 400 else None)
    open_page(studio)
    expect(page.locator("#pairs-kept")).to_have_text("450")

    # Where nobody has looked, the studio says so, and a look waits for what runs.
    film = studio.context.jobs.submit("film", busy)
    page.keyboard.press("x")
    waits = page.locator(".job[data-kind=preview]")
    expect(waits).to_contain_text("Waiting for the film to be done")
    studio.context.jobs.cancel(film.id)
    rows, none = page.locator("#conflicts > li"), page.locator("#conflicts-none")
    expect(rows).not_to_have_count(0)
    expect(page.locator("#conflicts-says")).not_to_contain_text("where little was shown")
    assert ["little was shown" in words for words in page.evaluate(MUCH)] == [True, False, False]
    alone = page.locator("#threshold-auto")
    page.locator("#threshold").fill("5")
    expect(alone).to_have_attribute("aria-pressed", "false")

    # In another session there is nothing, until its first take; what was chosen here ends here.
    page.locator("#new-session").click()
    page.locator("#session-name").fill("Other")
    page.keyboard.press("Enter")
    expect(rows).to_have_count(0)
    expect(none).to_have_text("Record a take first.")
    page.locator("#option-density").fill("0.1")  # nothing is hit so soon
    page.locator("#demonstrate").click()
    phase(page, "recording")
    at_least(page, "pairs", 60)
    page.locator("#stop").click()
    expect(none).to_be_empty()
    expect(page.locator("#conflicts-says")).to_contain_text("would go")
    expect(alone).to_have_attribute("aria-pressed", "true")

    # In another scene too.
    page.locator("#session").select_option(value=str(shown))
    expect(rows).not_to_have_count(0)
    page.locator("#scene").select_option("crowd")
    expect(rows).to_have_count(0)
    phase(page, "ready")
    expect(none).to_have_text("Record a take first.")
    expect(page.locator("#notice .error")).to_have_count(0)
    assert [url for url in complaints if "/conflicts" in url] == [], complaints
