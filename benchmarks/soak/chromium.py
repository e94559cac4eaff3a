"""A page in a real Chromium that demonstrates at a stage of its own."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from playwright.async_api import Page, ViewportSize, async_playwright

FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
WAIT_MS = 60_000
VIEWPORT: ViewportSize = {"width": 480, "height": 320}
"""Drawn by the processor."""


@asynccontextmanager
async def blank_page() -> AsyncIterator[Page]:
    """A page of a Chromium of its own, closed with it."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(FLAGS), headless=True
        )
        page = await browser.new_page(viewport=VIEWPORT)
        page.set_default_timeout(WAIT_MS)
        yield page
        await browser.close()


async def open_sparse(page: Page, url: str) -> None:
    """Open the studio at a field with few asteroids, ready to demonstrate."""
    await page.goto(url)
    await phase(page, "ready")
    await page.locator("#option-density").fill("0.1")


async def phase(page: Page, wanted: str) -> None:
    """Wait until the stage is in that phase."""
    await page.wait_for_selector(f"#phase[data-phase={wanted}]", state="attached")
