"""Side by side and blind votes, in real Chromium with real events."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Browser, Page, Response, expect

from evastudio.demonstrations.store import Store
from evastudio.evaluation import archive, preferences
from evastudio.evaluation.preferences import preference
from evastudio.live.balloting import open_ballot
from evastudio.live.evaluating import evaluate
from evastudio.live.lineup import Column, Lineup
from evastudio.live.tokens import Role, Tokens
from evastudio.live.turned import as_seen
from evastudio.world.bodies import Camera
from tests.browser.acting import until
from tests.browser.axe import barriers, barriers_in_light_and_dark
from tests.browser.test_comparing import enter
from tests.browser.test_looks import CONTROLS

if TYPE_CHECKING:
    from conftest import Running

TWO = ("asteroids-careful", "straight")


def lineups(studio: Running, owner: str = "") -> list[Lineup]:
    """What somebody looks at side by side."""
    return [one.lineup for one in studio.context.lineups.all(owner)]


def drawn(page: Page, studio: Running, owner: str = "") -> Lineup:
    """The lineup that somebody looks at, once the browser tells from where it sees each column."""
    expect(page.locator(".column iframe")).to_have_count(2)
    (lineup,) = lineups(studio, owner)
    until(page, lambda: studio.views.clients == 2)
    until(page, lambda: all(studio.views[one.name].cameras for one in lineup.columns))
    return lineup


def seen_from(studio: Running, column: Column) -> Camera:
    """Where the browser says it looks from in that column."""
    (client,) = studio.views[column.name]._server.get_clients().values()
    return Camera(client.camera.position, client.camera.look_at, client.camera.up_direction)


def looked_from(page: Page, studio: Running, column: Column) -> None:
    """Wait until the browser sees a column as the scene has it, at the moment of its lineup."""
    (lineup,) = lineups(studio)
    position = lineup.standing().position_s / column.scene.dt_s
    wanted = column.scene.camera(column.reel.shown(position)).position
    until(page, lambda: bool(np.abs(seen_from(studio, column).position - wanted).max() < 1e-2))


def aside(studio: Running, lineup: Lineup) -> list[np.ndarray]:
    """Where each column is seen from, as the scene's own camera sees it."""
    position = lineup.standing().position_s / lineup.scene.dt_s
    return [
        as_seen(
            lineup.scene.camera(column.reel.shown(position)), seen_from(studio, column)
        ).position
        for column in lineup.columns
    ]


def at(page: Page, lineup: Lineup, seconds: float) -> None:
    """Wait until the timeline stands there, and the studio too."""
    script = "([s, dt]) => Math.abs(document.getElementById('moment').valueAsNumber * dt - s) < .04"
    page.wait_for_function(script, arg=[seconds, lineup.scene.dt_s])
    until(page, lambda: abs(lineup.standing().position_s - seconds) < 0.01)


def test_two_are_looked_at_side_by_side_on_one_timeline(
    page: Page, run_studio: Callable[[], Running], pictures: Path
) -> None:
    page.set_viewport_size({"width": 1280, "height": 900})
    studio = run_studio()
    evaluate(studio.workspace, TWO, worlds=20, options={"density": 2.0})
    said = enter(page, studio)
    page.get_by_label(TWO[0]).check()
    expect(page.locator("#beside-says")).to_have_text("Choose one more to see side by side.")
    page.locator("#pilots summary").click()
    page.get_by_label(TWO[1], exact=True).check()
    page.locator("#option-density").fill("2")
    page.locator("#findings").focus()
    page.keyboard.press("b")
    lineup = drawn(page, studio)
    assert lineup.scene.values["density"] == 2.0
    expect(page.locator(".column strong")).to_have_text(list(TWO))
    expect(page.locator("#table small").first).to_be_visible()  # figures and intervals beneath

    # Where they part, marked on the timeline, and to its end.
    assert lineup.parts_s is not None
    expect(page.locator(".mark.parts title")).to_have_text(
        f"Here they part, {lineup.parts_s:.1f} s"
    )
    page.keyboard.press("d")
    at(page, lineup, lineup.parts_s)
    expect(page.locator(".moment-says")).to_contain_text("Here they part")
    page.keyboard.press("Shift+ArrowRight")
    at(page, lineup, lineup.parts_s + 1.0)
    for column in lineup.columns:
        looked_from(page, studio, column)
    page.screenshot(path=pictures / "side-by-side.png")
    assert barriers(page) == []
    assert page.evaluate(CONTROLS) == []
    page.keyboard.press("End")
    at(page, lineup, lineup.length_s)
    expect(page.locator(".column.over small")).to_have_count(1)
    page.keyboard.press("Home")
    at(page, lineup, 0.0)
    page.keyboard.press("Space")
    until(page, lambda: lineup.standing().position_s > 1.0)
    page.keyboard.press("Space")
    until(page, lambda: lineup.standing().speed == 0.0)
    for column in lineup.columns:
        looked_from(page, studio, column)

    # Turned by mouse in one column, both are turned, and stay so at another moment.
    box = page.locator(".column iframe").nth(1).bounding_box()
    assert box is not None
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 90, middle[1] + 20, steps=6)
    page.mouse.up()
    until(page, lambda: lineup.standing().turned)
    until(page, lambda: bool(np.ptp(aside(studio, lineup), axis=0).max() < 0.05))
    turned = aside(studio, lineup)[0]
    assert np.abs(turned).max() > 1.0
    page.keyboard.press("Shift+ArrowRight")
    until(page, lambda: bool(np.abs(np.array(aside(studio, lineup)) - turned).max() < 0.05))
    page.keyboard.press("Shift+V")
    until(page, lambda: bool(np.abs(aside(studio, lineup)).max() < 0.05))

    # A world in which one came through and the other did not.
    with Store(studio.workspace.store_url) as store:
        (evaluated,) = archive.evaluations(store)
        disputed = archive.find_evaluation(store, evaluated.id)[1].disputed()
    worlds = page.locator("#disputed button")
    expect(worlds).to_have_text([str(world + 1) for world in disputed][:12])
    worlds.last.click()
    expect(page.locator("#lineup-where")).to_contain_text(
        f"in world {disputed[:12][-1] + 1} of series 0"
    )
    until(page, lambda: lineup not in lineups(studio) != [])
    ends = [column.outcome == "crossed" for column in lineups(studio)[0].columns]
    assert sorted(ends) == [False, True]
    page.keyboard.press("Escape")
    expect(page.locator("#lineup")).to_be_hidden()
    until(page, lambda: lineups(studio) == [])
    assert said == []

    # Once more, to be looked at in both; views that go while they load complain in the console.
    page.locator("#findings").focus()
    page.keyboard.press("b")
    drawn(page, studio)
    assert barriers_in_light_and_dark(page) == []


def test_a_viewer_chooses_between_two_whose_names_come_after(
    browser: Browser, run_studio: Callable[[], Running], pictures: Path
) -> None:
    studio = run_studio()
    with Store(studio.workspace.store_url) as store:
        token = Tokens(store).add("Vera", Role.VIEWER, time.time())
        asked = open_ballot(
            studio.workspace, store, "asteroids", TWO, options={"density": 1.0}, seed=4, now=1.0
        )
    base = studio.url.partition("/?")[0]
    context = browser.new_context(viewport={"width": 1100, "height": 720})
    context.set_default_timeout(60_000)
    bodies: list[str] = []

    def keep(response: Response) -> None:
        if "/web/" not in response.url and "/view/" not in response.url:
            bodies.append(f"{response.url} {response.headers} {response.text()}")

    page = context.new_page()
    context.request.get(f"{base}/?token={token}")
    page.on("response", keep)
    page.goto(f"{base}/vote#{asked.id}")
    lineup = drawn(page, studio, "Vera")
    expect(page.locator(".column strong")).to_have_text(["Left", "Right"])
    page.keyboard.press("1")
    expect(page.locator("#choosing-says")).to_have_text("Let them go for a few seconds first.")
    page.locator("#roll-on").click()
    expect(page.locator("#choosing-says")).to_have_text("")
    for sign in page.locator(".rolling button svg path").all():
        expect(sign).to_be_visible()
    expect(page.locator(".moment-strip .line")).to_be_visible()
    page.screenshot(path=pictures / "vote.png")
    assert barriers_in_light_and_dark(page) == []
    before = list(bodies)
    assert len(before) >= 3
    for name in TWO:
        assert not [body for body in before if name in body]

    page.keyboard.press("1")
    expect(page.locator("#choosing-says")).to_contain_text("1 of 1 votes")
    left, right = (TWO[which] for which in asked.order("Vera", 0))
    expect(page.locator(".column strong")).to_have_text([f"Left{left}", f"Right{right}"])
    expect(page.locator("#choosing-says")).to_contain_text(f"{left} looked livelier than {right}")
    with Store(studio.workspace.store_url) as store:
        found = preference(store, asked)
        assert (sum(found.votes), found.people) == (1, 1)
        assert found.votes[TWO.index(left)] == 1
        assert preferences.votes_of(store, asked.id, "Vera") == 1
    assert barriers_in_light_and_dark(page) == []
    assert page.evaluate(CONTROLS) == []
    page.locator("#next-pair").click()
    until(page, lambda: lineup not in lineups(studio, "Vera") != [])
    expect(page.locator("#ballots a")).to_contain_text("1 vote, 1 of them yours")
    page.remove_listener("response", keep)
    context.close()
