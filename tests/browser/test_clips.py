"""Clips of one's own in the crowd, in real Chromium: dropped, chosen for walking, and walked."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Page, expect

from evastudio.motion.figures import figures
from evastudio.motion.library import CHOICES
from evastudio.motion.moment import Moment
from evastudio.motion.peopled import Peopled
from tests.motion.walker import bvh, glb, walking

if TYPE_CHECKING:
    from conftest import Open, Running


def test_a_clip_of_ones_own_is_dropped_chosen_and_walked(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    tmp_path: Path,
    pictures: Path,
) -> None:
    (tmp_path / "hero.glb").write_bytes(glb(walking(0.7), "Stroll"))
    (tmp_path / "broken.bvh").write_text(bvh(walking(1.2)).replace("Frames: ", "Frames: 9"))
    studio = run_studio()
    page.set_viewport_size({"width": 1100, "height": 800})
    page.add_init_script("localStorage.setItem('evastudio.scene', 'crowd')")
    opened = open_page(studio)
    scene = opened.stage.scene
    assert isinstance(scene, Peopled)

    page.locator("#movement summary").focus()
    page.keyboard.press("Enter")
    files = [tmp_path / "hero.glb", tmp_path / "broken.bvh"]
    page.locator("#clip-files").set_input_files(files)
    expect(page.locator("#clip-problems")).to_contain_text("'broken' claims 9")
    assert not (studio.workspace.motion / "broken.bvh").exists()

    choice = page.get_by_label("Walk", exact=True)
    with page.expect_response("**/clips/activities/walk"):
        choice.select_option(label="Stroll")
    expect(choice).to_be_focused()
    expect(choice).to_have_value("hero.glb/Stroll")
    page.screenshot(path=pictures / "movement.png")
    told = json.loads((studio.workspace.motion / CHOICES).read_text())
    assert told == {"walk": {"file": "hero.glb", "clip": "Stroll"}}

    page.locator("#policy").select_option("crowd-hurried")
    page.locator("#play").click()
    expect(page.locator("#phase[data-phase=playing]")).to_be_attached()
    playing = opened.stage.scene
    assert isinstance(playing, Peopled)
    view = studio.views[opened.stage.name]
    assert view.scene is playing
    moment = Moment(np.zeros((8, 2)), np.zeros(8), np.full(8, 1.4), np.arange(8) / 8)
    apart = playing.figures.joints(moment).positions - figures().joints(moment).positions
    assert np.abs(apart).max() > 0.02

    with page.expect_response("**/clips/activities/walk"):
        choice.select_option(label="As it comes")
    expect(choice).to_have_value("")
    expect(page.locator("#notice .error")).to_have_count(0)
    assert json.loads((studio.workspace.motion / CHOICES).read_text()) == {}
    assert opened.stage.scene.figures is figures()  # type: ignore[attr-defined]
