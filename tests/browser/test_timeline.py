"""Looking back along the timeline, and going on from there, in real Chromium with real events."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from evastudio.demonstrations.records import Origin
from evastudio.demonstrations.store import Store
from tests.browser.acting import at_least, camera, focus_view, moment, phase

if TYPE_CHECKING:
    from conftest import Open

MOMENT = "#moment"


def test_what_played_is_scrubbed_in_the_view_and_gone_on_from(
    page: Page, open_page: Callable[[], Open]
) -> None:
    opened = open_page()
    studio, stage = opened.studio, opened.stage
    page.locator("#option-density").fill("0.3")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 3)
    page.keyboard.press("l")
    phase(page, "reviewing")
    end = stage.status()["length_s"]
    moment(page, stage, end)
    dt_s = stage.scene.dt_s
    at_end = camera(studio, opened.view, near=stage.scene.camera(stage.snapshot).position)

    # By keys, from wherever the focus is.
    page.keyboard.press("Home")
    moment(page, stage, 0.0)
    begin = stage.scene.camera(stage.snapshot).position
    assert begin[0] < at_end[0] - 10.0
    camera(studio, opened.view, near=begin)
    for key, there in (("ArrowRight", dt_s), ("Shift+ArrowRight", dt_s + 1.0), ("ArrowLeft", 1.0)):
        page.keyboard.press(key)
        moment(page, stage, there)
    camera(studio, opened.view, near=stage.scene.camera(stage.snapshot).position)

    # By the mouse: half way along the line.
    box = page.locator(MOMENT).bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 60, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=12)
    page.mouse.up()
    moment(page, stage, end / 2, near=0.1)
    half = page.locator(MOMENT).evaluate("moment => moment.valueAsNumber") * dt_s
    words = page.locator(MOMENT).get_attribute("aria-valuetext") or ""
    assert words.startswith(f"{half:.1f} s of {end:.1f} s")
    expect(page.locator("#strip .line")).to_be_attached()

    # Backwards at double speed, to the beginning.
    page.locator(".speeds button", has_text="2").last.click()
    page.locator("#roll-back").click()
    moment(page, stage, 0.0)
    assert stage.status()["speed"] == 0.0

    # R records nothing; F begins a take at the moment that is looked at.
    page.keyboard.press("End")
    page.keyboard.press("r")
    page.keyboard.press("Shift+ArrowLeft")
    moment(page, stage, end - 1.0)
    step = round((end - 1.0) / dt_s)
    start = stage.snapshot["position"].copy()
    page.keyboard.press("f")
    phase(page, "recording")
    focus_view(page)
    page.keyboard.down("a")
    at_least(page, "pairs", 10)
    page.keyboard.up("a")
    page.keyboard.press("Escape")
    phase(page, "ready")
    at_least(page, "takes-kept", 1)
    with Store(studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id)
        data = store.load_take(take.id)
    assert take.origin is not None
    assert (take.origin.policy, take.origin.step) == ("asteroids-careful", step)
    assert data.snapshots["position"][0] == pytest.approx(start[0])


def test_a_paused_take_is_looked_back_at_and_gone_on_with(
    page: Page, open_page: Callable[[], Open]
) -> None:
    opened = open_page()
    studio, stage = opened.studio, opened.stage
    page.locator("#option-density").fill("0.3")
    page.locator("#demonstrate").click()
    phase(page, "recording")
    focus_view(page)
    at_least(page, "pairs", 20)
    page.keyboard.press("Space")
    phase(page, "paused")
    stood = stage.status()["seconds"]
    page.keyboard.press("l")
    phase(page, "reviewing")
    page.keyboard.press("Home")
    moment(page, stage, 0.0)
    page.keyboard.press("Escape")
    phase(page, "paused")
    assert stage.status()["seconds"] == stood
    page.keyboard.press("Space")
    phase(page, "recording")
    at_least(page, "pairs", 40)

    # The end of it is looked back at, and what follows is tried again from there.
    page.keyboard.press("Space")
    phase(page, "paused")
    page.keyboard.press("l")
    phase(page, "reviewing")
    page.keyboard.press("Home")
    page.keyboard.press("Shift+ArrowRight")
    moment(page, stage, 1.0)
    page.keyboard.press("f")
    phase(page, "recording")
    at_least(page, "pairs", 8)
    page.keyboard.press("Space")
    phase(page, "paused")
    expect(page.locator("#keys [data-use=there]")).to_be_visible()
    page.keyboard.press("Shift+R")
    phase(page, "recording")
    at_least(page, "pairs", 3)
    page.keyboard.press("Space")
    phase(page, "paused")

    # More is asked of it than it has: all is kept. Then its end alone.
    page.keyboard.press("k")
    expect(page.locator("#notice")).to_contain_text("all of it is kept")
    phase(page, "paused")
    page.locator("#keys select").select_option("2")
    focus_view(page)
    page.keyboard.press("Space")
    phase(page, "recording")
    at_least(page, "pairs", 36)
    page.keyboard.press("k")
    phase(page, "ready")
    expect(page.locator("#takes-count")).to_contain_text("1 in the trash")
    with Store(studio.workspace.store_url) as store:
        session = store.sessions()[0].id
        first, fork, end = store.takes(session)
        (again,) = store.takes(session, trashed=True)
        forks = [fork, again]
        assert (end.pairs, end.origin) == (30, Origin(again.pairs - 30, take=again.id))
        whole = store.load_take(first.id).snapshots["position"]
        starts = [store.load_take(fork.id).snapshots["position"][0] for fork in forks]
    assert first.pairs >= 40
    for fork, start in zip(forks, starts, strict=True):
        assert fork.origin is not None
        assert (fork.origin.take, fork.origin.step) == (first.id, 15)
        assert np.array_equal(start, whole[15])
