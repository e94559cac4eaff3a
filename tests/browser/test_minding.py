"""What a beginner minds: advice as they fly, the good end of a take, a fit that takes too long."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Page, expect

import evastudio
from evastudio.demonstrations.records import RECORDED
from tests.browser.acting import at_least, phase

if TYPE_CHECKING:
    from conftest import Open, Running

FREE = 5
"""A world with hardly a rock in it, through which one comes without steering."""


def test_one_is_advised_keeps_the_end_of_a_take_and_ends_a_fit(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    evastudio.record(studio.workspace, "asteroids", minutes=1.5, seed=4, session="Calm")
    stage = open_page(studio).stage
    store, jobs = studio.context.store, studio.context.jobs
    (session,) = store.sessions()
    stage.demonstrate({"density": 0.1}, seed=FREE)
    phase(page, "recording")
    expect(page.locator("#coach")).to_be_empty()
    expect(page.locator("#coach")).to_contain_text("You have hardly steered.")
    page.screenshot(path=pictures / "coach.png")

    # What went before is in the trash, and what is kept begins where it was.
    page.locator("#keys select").select_option("3")
    page.keyboard.press("k")
    phase(page, "ready")
    expect(page.locator("#notice")).to_contain_text("Its last 3 s are kept")
    at_least(page, "takes-kept", session.takes_kept + 1)
    (whole,) = store.takes(session.id, trashed=True)
    kept = store.takes(session.id)[-1]
    assert (kept.pairs, kept.seed) == (45, RECORDED)
    assert kept.origin is not None
    assert (kept.origin.take, kept.origin.step) == (whole.id, whole.pairs - 45)
    expect(page.locator("#coach")).to_be_empty()

    page.locator("label:has(input[name=learner][value=auto])").click()
    page.locator("#fit").click()
    working = page.locator(".job[data-kind=fit]")
    expect(working.locator("progress")).to_be_visible()
    working.get_by_text("Cancel").click()
    expect(working).to_be_hidden()
    assert [job.state for job in jobs.all()] == ["cancelled"]
    assert list(studio.workspace.policies.iterdir()) == []
    page.locator("label:has(input[name=learner][value=knn])").click()
    page.locator("#fit").click()
    expect(page.locator("#policy")).to_have_value("calm-knn")
