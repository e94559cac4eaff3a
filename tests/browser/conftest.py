"""Real Chromium at a studio that runs in this process, so that tests can look at both ends."""

from __future__ import annotations

import os
import shutil
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import uvicorn
from fastapi import FastAPI
from playwright.sync_api import Browser, Frame, Page, Playwright, expect, sync_playwright

from evastudio.api.context import Context
from evastudio.live.live_stage import LiveStage
from evastudio.server import create_app
from evastudio.settings import Settings
from evastudio.studio.views import Views
from evastudio.workspace import Workspace

FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
WAIT_MS = 60_000

expect.set_options(timeout=WAIT_MS)


@pytest.fixture(scope="module")
def playwright() -> Iterator[Playwright]:
    """Closed after each module: its event loop would be in the way of other tests' own."""
    with sync_playwright() as started:
        yield started


@pytest.fixture(scope="module")
def browser(playwright: Playwright) -> Iterator[Browser]:
    chromium = playwright.chromium.launch(
        executable_path=shutil.which("chromium"), args=FLAGS, headless=True
    )
    yield chromium
    chromium.close()


@pytest.fixture
def page(browser: Browser, run_studio: Callable[[], Running]) -> Iterator[Page]:
    """An empty page, closed before the studio ends; the test fails if anything throws in it."""
    context = browser.new_context(
        viewport={"width": 960, "height": 600}, color_scheme="dark", reduced_motion="reduce"
    )
    context.set_default_timeout(WAIT_MS)
    opened = context.new_page()
    thrown: list[str] = []
    opened.on("pageerror", lambda error: thrown.append(str(error)))
    yield opened
    context.close()
    assert thrown == []


@dataclass
class Running:
    """A studio on a thread of this process."""

    url: str
    workspace: Workspace
    app: FastAPI
    server: uvicorn.Server

    @property
    def context(self) -> Context:
        found: Context = self.app.state.context
        return found

    @property
    def views(self) -> Views:
        found: Views = self.app.state.views
        return found


@dataclass
class Open:
    """The page of a studio, once its 3D view draws."""

    studio: Running
    stage: LiveStage
    view: Frame


@pytest.fixture
def run_studio(tmp_path: Path) -> Iterator[Callable[[], Running]]:
    """Start a studio on an empty workspace; it is stopped after the test."""
    ends: list[Callable[[], None]] = []

    def start() -> Running:
        listener = socket.socket()
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        port = listener.getsockname()[1]
        settings = Settings(Workspace(tmp_path / "work"), port=port, browser=False)
        app = create_app(settings, port)
        config = uvicorn.Config(
            app, log_level="warning", ws="websockets-sansio", timeout_graceful_shutdown=3
        )
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()

        def end() -> None:
            server.should_exit = True
            thread.join()
            listener.close()

        ends.append(end)
        return Running(
            f"http://127.0.0.1:{port}/?token={settings.token}", settings.workspace, app, server
        )

    yield start
    for end in ends:
        end()


def enter(page: Page, studio: Running) -> Open:
    """Open the printed address and wait until the stage is there and drawn."""
    page.goto(studio.url)
    element = page.wait_for_selector("#view[src]")
    assert "token" not in page.url
    assert element is not None
    frame = element.content_frame()
    assert frame is not None
    frame.wait_for_selector("canvas")
    expect(page.locator("#phase[data-phase=ready]")).to_be_attached()
    (stage,) = studio.context.stages.all()
    return Open(studio, stage, frame)


@pytest.fixture
def open_page(page: Page, run_studio: Callable[[], Running]) -> Callable[[], Open]:
    """Open the page of a studio, as `enter` does, and of a new one where none is given."""
    return lambda studio=None: enter(page, studio or run_studio())


@pytest.fixture(scope="session")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where screenshots go: EVASTUDIO_PICTURES, or a folder that is thrown away."""
    chosen = os.environ.get("EVASTUDIO_PICTURES")
    folder = Path(chosen) if chosen else tmp_path_factory.mktemp("pictures")
    folder.mkdir(parents=True, exist_ok=True)
    return folder
