"""axe-core, which looks at a page for what keeps people out."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any, Literal

from playwright.sync_api import Frame, Page, expect

SERIOUS = {"serious", "critical"}
RUN = """async () => {
  const found = await axe.run(document, {iframes: false, resultTypes: ["violations"]});
  return found.violations.map(({id, impact, nodes}) =>
    ({id, impact, nodes: nodes.map(({target, failureSummary}) =>
      `${target.join(" ")}: ${failureSummary}`)}));
}"""


@cache
def source() -> str:
    return (files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8")


def barriers(page: Page | Frame, least: frozenset[str] = frozenset(SERIOUS)) -> list[Any]:
    """What axe says of the page or of a frame alone: its rule, how bad it is, and where."""
    if not page.evaluate("typeof axe !== 'undefined'"):
        page.evaluate(source())
    return [found for found in page.evaluate(RUN) if found["impact"] in least]


def barriers_in_light_and_dark(page: Page) -> list[Any]:
    """What axe says of the page in both; it stays in the dark one, and without motion."""
    found: list[Any] = []
    schemes: tuple[Literal["light", "dark"], ...] = ("light", "dark")
    for scheme in schemes:
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        expect(page.locator("html")).to_have_attribute("data-scheme", scheme)
        found += barriers(page)
    return found
