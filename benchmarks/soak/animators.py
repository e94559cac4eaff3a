"""Two animators at once, each at a browser and a stage of their own: do their keys ever cross?

One presses only the keys that turn left and climb, the other only those that turn right and dive,
so that whatever crossed would show in the store as a turn that its animator cannot make.

python -m benchmarks.soak --only animators
"""

from __future__ import annotations

import asyncio
import os
import random
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.soak.chromium import blank_page, open_sparse, phase
from benchmarks.soak.load import replay_all
from benchmarks.soak.observed import observed
from benchmarks.soak.section import Section
from evastudio.demonstrations.store import Store
from evastudio.workspace import Workspace

SECONDS = 300.0
SIDES = (("a", "w", "ArrowLeft", "ArrowUp"), ("d", "s", "ArrowRight", "ArrowDown"))
"""The keys of each animator, who has no others: to the left and up, and to the right and down."""
SIGNS = (1.0, -1.0)
"""Of every turn in the store that comes of those keys."""
LONGEST_S = 0.4
"""A key is held so long at most, and let alone so long."""


@dataclass
class Animator:
    """What one did, and what their page told of it."""

    session: int = 0
    presses: int = 0
    thrown: list[str] = field(default_factory=list)
    """Errors in the page, and those it told."""


@dataclass(frozen=True)
class Found:
    """What the store holds of one animator."""

    takes: int
    pairs: int
    turned: int
    """Pairs with a turn."""
    crossed: int
    """Pairs with a turn that only the other's keys make."""


async def animate(
    url: str, keys: Sequence[str], seconds: float, seed: int, ready: asyncio.Barrier
) -> Animator:
    """Demonstrate at a browser of one's own, take after take, until the time is up."""
    found = Animator()
    rng = random.Random(seed)
    async with blank_page() as page:
        page.on("pageerror", lambda error: found.thrown.append(str(error)))
        await open_sparse(page, url)
        await ready.wait()  # both have opened a stage, and there is no session yet
        await page.locator("#demonstrate").click()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            key = rng.choice(keys)
            await page.keyboard.down(key)
            await asyncio.sleep(rng.uniform(0.0, LONGEST_S))
            await page.keyboard.up(key)
            found.presses += 1
            await asyncio.sleep(rng.uniform(0.0, LONGEST_S))
            if await page.locator("#phase").get_attribute("data-phase") == "ended":
                await page.keyboard.press("r")
                await phase(page, "recording")
        await page.locator("#stop").click()
        await phase(page, "ready")
        found.session = int(await page.locator("#session").input_value())
        found.thrown += await page.locator("#notice .error").all_inner_texts()
    return found


def together(url: str, seconds: float, seed: int) -> list[Animator]:
    """Both at once."""

    async def both() -> list[Animator]:
        ready = asyncio.Barrier(len(SIDES))
        work = [animate(url, keys, seconds, seed + n, ready) for n, keys in enumerate(SIDES)]
        return await asyncio.gather(*work)

    return asyncio.run(both())


def kept(workspace: Workspace, animators: Sequence[Animator]) -> list[Found]:
    """What the store holds of each."""
    found = []
    with Store(workspace.store_url) as store:
        for animator, sign in zip(animators, SIGNS, strict=True):
            takes = store.takes(animator.session)
            actions = np.concatenate([store.load_take(take.id).actions for take in takes])
            found.append(
                Found(
                    len(takes),
                    len(actions),
                    int((actions != 0.0).any(axis=1).sum()),
                    int((sign * actions < 0.0).any(axis=1).sum()),
                )
            )
    return found


def run(quick: bool, seed: int) -> bool:
    """Whether no key crossed, every take replays, and nothing went wrong in a page."""
    section = Section("animators", "scenes", "web")
    seconds = 20.0 if quick else SECONDS
    with tempfile.TemporaryDirectory() as folder, observed(Path(folder)) as studio:
        before = studio.sample()
        animators = together(studio.front_door, seconds, seed)
        after = studio.sample()
        steps, late = after.steps - before.steps, after.late_since(before)
        found = kept(studio.workspace, animators)
        sessions = [animator.session for animator in animators]
        replayed, differing = replay_all(studio, sessions)
    rows = [
        f"| {' '.join(keys)} | {animator.presses} | {one.takes}, {one.pairs} | {one.turned} | "
        f"{one.crossed} |"
        for keys, animator, one in zip(SIDES, animators, found, strict=True)
    ]
    section.write(
        [
            f"## Two animators at once for {seconds / 60:.1f} minutes",
            "",
            "Each sits at a Chromium and a stage of their own in one studio and demonstrates take "
            "after take, with real key events at random; one has only the keys to the left and "
            "up, the other only those to the right and down, so that a turn shows whose it was.",
            "",
            "| keys | presses | takes, pairs in the store | with a turn | with a turn of the "
            "other's |",
            "|---|---|---|---|---|",
            *rows,
            "",
            f"{replayed} takes were replayed from their actions, {differing} of them differ. "
            f"{steps:.0f} decisions, {late:.1%} of them over half a step late while both browsers "
            "draw on the processor's same cores. Load of the machine in the last minute: "
            f"{os.getloadavg()[0]:.1f}.",
        ],
        quick,
    )
    thrown = [line for animator in animators for line in animator.thrown]
    for line in thrown[:5]:
        print("in a page:", line)
    crossed = sum(one.crossed for one in found)
    return crossed == differing == 0 and not thrown and min(one.turned for one in found) > 0
