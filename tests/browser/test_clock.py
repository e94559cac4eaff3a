"""The stage holds its 15 decisions a second for a minute while a browser looks on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from playwright.sync_api import Page, expect

from evastudio.demonstrations.store import Store
from evastudio.workspace import shipped

if TYPE_CHECKING:
    from conftest import Open, Running

SECONDS = 60.0


def test_sixty_seconds_without_drift(
    page: Page, run_studio: Callable[[], Running], open_page: Callable[[Running], Open]
) -> None:
    studio = run_studio()
    # The shipped field takes 36 s to cross; this one 72 s.
    folder = studio.workspace.root / "scenes"
    folder.mkdir()
    text = (shipped() / "scenes" / "asteroids.py").read_text()
    assert "\nLENGTH = 360.0\n" in text
    (folder / "asteroids.py").write_text(text.replace("\nLENGTH = 360.0\n", "\nLENGTH = 720.0\n"))

    page.set_viewport_size({"width": 640, "height": 360})  # drawn by the processor, not a GPU
    stage = open_page(studio).stage
    dt_s = stage.scene.dt_s
    seen: list[tuple[float, dict[str, Any]]] = []
    enough = threading.Event()

    def told(status: dict[str, Any]) -> None:
        if status["phase"] == "recording" and status["steps"] > 0:
            seen.append((time.monotonic(), status))
        if status["steps"] * dt_s >= SECONDS or status["phase"] == "ended":
            enough.set()

    stage.on_status.append(told)
    page.locator("#option-density").fill("0.1")
    page.locator("#demonstrate").click()
    assert enough.wait(2 * SECONDS)
    page.locator("#stop").click()
    expect(page.locator("#phase[data-phase=ready]")).to_be_attached()

    (began, first), (ended, last) = seen[0], seen[-1]
    steps = last["steps"] - first["steps"]
    assert steps * dt_s > SECONDS - 1.0
    # Told by the stage itself, and measured from outside: each tells within a step of the other.
    # One telling may reach us late; of a quarter of them the promptest shows how the clock stands.
    assert last["drift_s"] < dt_s
    behind = [at - status["steps"] * dt_s for at, status in seen]
    quarter = len(seen) // 4
    assert abs(min(behind[-quarter:]) - min(behind[:quarter])) < 2 * dt_s
    assert last["late_steps"] == stage.status()["late_steps"]
    shown = page.locator("#late").text_content()
    print(f"{steps} steps in {ended - began:.3f} s, {last['late_steps']} late; page: {shown!r}")
    with Store(studio.workspace.store_url) as store:
        (take,) = store.takes(store.sessions()[0].id)
        data = store.load_take(take.id)
    assert take.pairs == len(data.actions) >= last["steps"]
    assert data.snapshots["steps"].tolist() == list(range(take.pairs))
