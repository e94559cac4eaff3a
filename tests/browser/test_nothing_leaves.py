"""No request leaves the machine: everything that the browser and the studio ask for is watched.

The browser sends what is not for this machine to a proxy, which is the test's own and only writes
down what comes; so what Chromium itself or a worker asks for is seen too. What Python connects to
is seen by an audit hook.
"""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, WebSocket, expect

from evastudio.demonstrations.store import Store
from evastudio.live.tokens import Role, Tokens
from tests.browser.acting import at_least, phase
from tests.browser.conftest import WAIT_MS

if TYPE_CHECKING:
    from conftest import Running

AUTOFILL = "CONNECT content-autofill.googleapis.com:443 "
"""Chrome tells its maker which kinds of fields any form has; no page can forbid it."""
HERE = ("127.0.0.1", "::1", "localhost")
connected: list[str] = []


def note(event: str, arguments: tuple[Any, ...]) -> None:
    """Audit hooks stay for as long as the process lives; this one only writes down."""
    if event == "socket.connect":
        connected.append(str(arguments[1]))
    elif event == "socket.getaddrinfo":
        connected.append(str(arguments[0]))


@pytest.fixture
def outside() -> Iterator[tuple[str, list[str]]]:
    """The address of a proxy, and the first line of every request that came to it."""
    asked: list[str] = []

    def listen() -> None:
        while True:
            try:
                wire, _ = listener.accept()
            except OSError:  # closed
                return
            with wire:
                wire.settimeout(5.0)
                asked.append(wire.recv(4096).decode("latin-1").partition("\r\n")[0])

    listener = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=listen)
    thread.start()
    yield f"http://127.0.0.1:{listener.getsockname()[1]}", asked
    listener.shutdown(socket.SHUT_RDWR)
    listener.close()
    thread.join()


class Watch:
    """What the pages of a context ask for."""

    def __init__(self, context: BrowserContext) -> None:
        self.addresses: list[str] = []
        context.on("request", lambda request: self.addresses.append(request.url))
        context.on("page", lambda page: page.on("websocket", self._socket))

    def _socket(self, socket: WebSocket) -> None:
        self.addresses.append(socket.url)

    def elsewhere(self, base: str) -> list[str]:
        """Addresses that are neither of the studio nor held in themselves."""
        own = urlsplit(base).netloc
        return [
            address
            for address in self.addresses
            if urlsplit(address).netloc != own
            and urlsplit(address).scheme not in {"data", "blob", "about"}
        ]


def test_no_request_leaves_the_machine(
    browser: Browser, run_studio: Callable[[], Running], outside: tuple[str, list[str]]
) -> None:
    sys.addaudithook(note)
    studio = run_studio()
    base, _, token = studio.url.partition("/?token=")
    with Store(studio.workspace.store_url) as store:
        viewer = Tokens(store).add("Vera", Role.VIEWER, 0.0)
    proxy, asked = outside
    watches: list[Watch] = []
    connected.clear()

    def entered(secret: str) -> Page:
        context = browser.new_context(
            viewport={"width": 640, "height": 480}, proxy={"server": proxy, "bypass": "127.0.0.1"}
        )
        watches.append(Watch(context))
        page = context.new_page()
        page.set_default_timeout(WAIT_MS)
        page.goto(f"{base}/?token={secret}")
        return page

    page = entered(token)
    element = page.wait_for_selector("#view[src]")
    assert element is not None
    frame = element.content_frame()
    assert frame is not None
    frame.wait_for_selector("canvas")
    page.locator("#option-density").fill("0.5")
    page.locator("#demonstrate").click()
    phase(page, "recording")
    at_least(page, "pairs", 20)
    watching = entered(viewer)
    expect(watching.locator("#watched")).to_contain_text("stage 1")
    watching.context.close()
    page.locator("#stop").click()
    phase(page, "ready")
    page.locator("label:has(input[name=learner][value=knn])").click()
    page.locator("#fit").click()
    expect(page.locator("#notice")).to_contain_text("ready to play")
    page.locator("#play").click()
    phase(page, "playing")
    at_least(page, "seconds", 0.5)
    for path in ("/compare", "/api/v1/openapi.json"):
        page.goto(base + path)
        page.wait_for_load_state("networkidle")

    addresses = [address for watch in watches for address in watch.addresses]
    assert any(address.startswith("ws:") and "/view/" in address for address in addresses)
    assert [address for watch in watches for address in watch.elsewhere(base)] == []
    assert [place for place in connected if not any(host in place for host in HERE)] == []
    assert [line for line in asked if not line.startswith(AUTOFILL)] == []

    # The proxy sees what goes elsewhere: the checks above can fail.
    page.goto("about:blank")
    page.evaluate("fetch('http://studio.example/').catch(() => 0)")
    assert "GET http://studio.example/ HTTP/1.1" in asked
    page.context.close()
