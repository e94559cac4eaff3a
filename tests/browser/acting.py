"""What a person does at the page, and what they wait to see there."""

from __future__ import annotations

from playwright.sync_api import Page, expect


def phase(page: Page, wanted: str) -> None:
    """Wait until the stage is in that phase."""
    expect(page.locator(f"#phase[data-phase={wanted}]")).to_be_attached()


def at_least(page: Page, element: str, count: float) -> None:
    """Wait until the number that `element` shows is at least `count`."""
    script = "([id, count]) => Number(document.getElementById(id).textContent) >= count"
    page.wait_for_function(script, arg=[element, count])


def focus_view(page: Page) -> None:
    """Click into the 3D view, as a person does."""
    box = page.locator("#view").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert page.evaluate("document.activeElement.id") == "view"
