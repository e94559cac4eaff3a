"""The list of takes, in real Chromium: looked at, noted, thrown away and brought back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Page, expect

from evastudio.demonstrations.records import RECORDED
from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.workspace import Workspace, shipped
from evastudio.world.loading import load_scene_file
from tests.browser.acting import FRAMES, at_least, camera, moment, phase

if TYPE_CHECKING:
    from conftest import Open, Running

FIELD = {"density": 1.0}
LONG, SHORT = 40, 15
"""Pairs of takes that are made."""


def made(workspace: Workspace) -> tuple[int, list[int]]:
    """A session of two demonstrated takes and fifty made from them; its id, and theirs."""
    headless.record(workspace, "asteroids", minutes=0.8, seed=3, options=FIELD, session="Shown")
    headless.fit(workspace, "Shown", learner="knn", delay="off", name="own")
    scene = load_scene_file(shipped() / "scenes" / "asteroids.py")(**FIELD)
    with Store(workspace.store_url) as store:
        session = store.session("Shown").id
        first = max(store.takes(session), key=lambda take: take.pairs)
        data = store.load_take(first.id)
        fixed = {name: array[:1] for name, array in data.snapshots.fixed.items()}
        view = scene.perception().name
        for number in range(50):
            pairs = SHORT if number == 49 else LONG if number < 40 else 240 + 15 * (number % 4)
            part = slice(6 * number, 6 * number + pairs)
            take = store.begin_take(session, scene, view, RECORDED, "person", fixed, 0.0)
            moving = {name: array[part] for name, array in data.snapshots.moving.items()}
            store.append(take, 0, data.states[part], data.actions[part], moving)
            store.finish_take(take, "crossed" if number % 3 == 0 else None, 1.0)
        return session, [take.id for take in store.takes(session)]


def test_takes_are_looked_at_noted_and_thrown_away(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    pictures: Path,
) -> None:
    studio = run_studio()
    session, ids = made(studio.workspace)
    page.set_viewport_size({"width": 1180, "height": 720})
    opened = open_page(studio)
    stage, last = opened.stage, ids[-1]
    expect(page.locator("#takes-count")).to_contain_text(f"{len(ids)} kept")
    page.locator("#takes-box summary").click()

    # A page of them at first, each with its picture.
    rows = page.locator("#takes > li")
    expect(rows).to_have_count(20)
    row = page.locator(f"#takes > li[data-take='{last}']")
    expect(rows.first).to_have_attribute("data-take", str(last))
    page.wait_for_function(
        "take => document.querySelector(`li[data-take='${take}'] img`)?.naturalWidth > 0", arg=last
    )
    expect(row.locator(".remark").first).to_contain_text("Only 1.0 s long")
    expect(page.locator("#takes-count")).to_contain_text("to look at again")

    # A note is kept as it was written, and is no part of the page.
    row.get_by_text("Note", exact=True).click()
    row.locator("textarea").fill("<b id='bold'>Too</b> short")
    page.keyboard.press("Enter")
    expect(row.locator(".note")).to_have_text("<b id='bold'>Too</b> short")
    assert page.locator("#bold").count() == 0
    with Store(studio.workspace.store_url) as store:
        assert store.take(last).note == "<b id='bold'>Too</b> short"

    row.get_by_text("Note", exact=True).click()
    row.locator("textarea").fill("Began too late")
    row.get_by_text("Keep note").click()
    expect(row.locator(".note")).to_have_text("Began too late")

    row.locator("[data-does=trash]").click()
    expect(page.locator("#takes-count")).to_contain_text("1 in the trash")
    with Store(studio.workspace.store_url) as store:
        assert [take.id for take in store.takes(session, trashed=True)] == [last]
    row.locator("[data-does=trash]").click()
    expect(page.locator("#takes-count")).not_to_contain_text("trash")

    page.locator("#takes-more").click()
    expect(rows).to_have_count(40)

    # A take is looked at in the view, from its beginning on; then one is where one was.
    start = camera(studio, opened.view)
    page.locator(f"#takes > li[data-take='{ids[-2]}'] .thumbnail").click()
    phase(page, "reviewing")
    expect(page.locator("#phase")).to_have_text(f"Looking at take {len(ids) - 1}")
    page.locator(".speeds button", has_text="8").click()
    page.wait_for_function(
        "() => { const m = document.getElementById('moment'); return m.value === m.max; }"
    )
    for _ in range(6):
        page.keyboard.press("Shift+ArrowLeft")
    length = stage.status()["length_s"]
    moment(page, stage, length - 6.0)
    camera(studio, opened.view, near=stage.scene.camera(stage.snapshot).position)
    page.screenshot(path=pictures / "takes.png")
    page.keyboard.press("End")
    moment(page, stage, length)
    with Store(studio.workspace.store_url) as store:
        data = store.load_take(ids[-2])
    end = stage.scene.camera(stage.snapshot).position
    assert np.abs(stage.snapshot["position"][0] - data.snapshots["position"][-1]).max() < 1.0
    assert end[0] > start[0] + 10.0
    camera(studio, opened.view, near=end)

    # Only what begins from a button here records.
    page.keyboard.press("r")
    page.keyboard.press("Backspace")
    page.keyboard.press("Escape")
    phase(page, "ready")
    with Store(studio.workspace.store_url) as store:
        assert store.session(session).takes_kept == len(ids)

    # Of what plays by one's own takes the line has the colours of how familiar it was.
    page.locator("#policy").select_option("own")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 3)
    page.keyboard.press("l")
    phase(page, "reviewing")
    expect(page.locator("#strip rect[fill]").nth(20)).to_be_attached()
    page.keyboard.press("Shift+ArrowLeft")
    expect(page.locator("#moment-says")).to_contain_text("like your takes")
    moment(page, stage, stage.status()["length_s"] - 1.0)
    camera(studio, opened.view, near=stage.scene.camera(stage.snapshot).position)
    page.evaluate(FRAMES, 20)
    page.screenshot(path=pictures / "timeline.png")
