"""No press is lost, however short: what the keyboard did is what the store holds."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import Page

from tests.browser.organist import sit_down
from tests.scenes.organ import CODES, Organ

if TYPE_CHECKING:
    from conftest import Running

SEQUENCES = 1000
KEYS = 2
"""Of each sequence; so many others go on at the same time as there are keys for."""
MOST_EDGES = 8
Edge = tuple[str, bool]
"""A key, and whether it goes down."""


def sequence(rng: random.Random, keys: Sequence[str]) -> list[Edge]:
    """Presses and releases of those keys in random order; in the end none is held."""
    held: set[str] = set()
    edges: list[Edge] = []
    for _ in range(rng.randint(1, MOST_EDGES)):
        key = rng.choice(keys)
        held ^= {key}
        edges.append((key, key in held))
    return edges + [(key, False) for key in rng.sample(sorted(held), len(held))]


def merged(rng: random.Random, sequences: Sequence[Sequence[Edge]]) -> Iterator[Edge]:
    """All of them at once, each in its own order."""
    left = [list(one) for one in sequences]
    while left := [one for one in left if one]:
        yield rng.choice(left).pop(0)


def held_s(felt: Sequence[tuple[str, str, float]]) -> dict[str, list[float]]:
    """How long each key was held, each time, by what Chromium told of it."""
    since: dict[str, float] = {}
    found: dict[str, list[float]] = {}
    for kind, code, time_ms in felt:
        if kind == "keydown":
            since[code] = time_ms
        else:
            found.setdefault(code, []).append((time_ms - since.pop(code)) / 1000.0)
    assert not since
    return found


def test_a_thousand_sequences_of_presses_are_recorded(
    page: Page, run_studio: Callable[[], Running]
) -> None:
    organist = sit_down(page, run_studio())
    rng = random.Random(7)
    groups = [CODES[first : first + KEYS] for first in range(0, len(CODES), KEYS)]
    sequences = [sequence(rng, groups[number % len(groups)]) for number in range(SEQUENCES)]
    rounds: list[tuple[int, int, list[Edge]]] = []
    start = organist.rest(1)
    for first in range(0, SEQUENCES, len(groups)):
        edges = list(merged(rng, sequences[first : first + len(groups)]))
        for key, down in edges:
            (page.keyboard.down if down else page.keyboard.up)(key)
        presses = Counter(key for key, down in edges if down)
        end = organist.rest(2 + max(presses.values()))
        rounds.append((start, end, edges))
        start = end
    felt = iter(page.evaluate("felt"))
    actions = organist.finish()

    apart, taps = [], 0
    for start, end, edges in rounds:
        times_s = held_s([next(felt) for _ in edges])
        played = actions[start:end]
        assert not played[-1].any(), "a key is held on after its release"
        for number, code in enumerate(CODES):
            steps, presses = played[:, number].sum(), times_s.get(code, [])
            # A press counts for one step at least, whenever it came and however short it was.
            assert steps > len(presses) - 1e-6, f"{len(presses)} presses of {code} are {steps}"
            assert presses or steps == 0.0, f"{code} is recorded and was not pressed"
            if presses:
                apart.append(abs(steps - sum(max(one / Organ.dt_s, 1.0) for one in presses)))
            taps += sum(one < Organ.dt_s for one in presses)
    assert next(felt, None) is None
    print(
        f"{SEQUENCES} sequences, {sum(len(edges) for *_, edges in rounds) // 2} presses, {taps} of "
        "them shorter than a step; recorded as long as Chromium says, to a millisecond, were "
        f"{np.mean(np.array(apart) * Organ.dt_s < 0.001):.1%}"
    )
