"""What the coach makes of demonstrators that are programs, each with its own way of steering."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from evastudio.live.act import COUNTDOWN_S
from evastudio.live.coach import Coach, Decisions, Remembered, judged
from evastudio.live.run import Run
from evastudio.live.stage import Stage
from evastudio.live.status import Advice
from evastudio.pilots.scripted import ScriptedPilot, find_pilot
from evastudio.pilots.straight import StraightPilot
from evastudio.pilots.traits import Traits
from evastudio.world.rollout import Pilot, roll_out
from evastudio.world.scene import Scene, world_seeds
from tests.live.test_stage import run

EARLY = ScriptedPilot(Traits(smoothing=0.3, intention={"berth": 2.0}))
"""Corrects early and minutely: it passes rocks by a hair."""


class Blind(StraightPilot):
    """Shakes the stick whatever comes."""

    name = "blind"

    def act(self, scene, snapshot, memory):  # type: ignore[no-untyped-def]
        luck = [np.random.default_rng(int(1000 * x)) for x in snapshot["position"][:, 0]]
        shaken = np.array([one.uniform(-1.0, 1.0, 2) for one in luck])
        return scene.action.high * shaken, memory


def flown(scene: Scene, pilot: Pilot, flights: int = 3, steps: int = 540) -> Decisions:
    """Every decision of some flights."""
    view = scene.perception()
    takes: list[list[Decisions]] = [[] for _ in range(flights)]

    def watch(alive, snapshot, actions):  # type: ignore[no-untyped-def]
        percept = view.perceive(snapshot)
        for row, take in enumerate(alive):
            one = slice(row, row + 1)
            told = percept.states[one], percept.frame[one], actions[one], np.array([take])
            takes[take].append(Decisions(*told))

    roll_out(scene, pilot, world_seeds(3, flights), max_steps=steps, watcher=watch)
    parts = zip(*(moment for take in takes for moment in take), strict=True)
    return Decisions(*(np.concatenate(part) for part in parts))


@pytest.mark.parametrize("style", ["careful", "human", "keys"])
def test_who_answers_visibly_is_told_to_go_on(asteroids: Callable[..., Scene], style: str) -> None:
    scene = asteroids(density=4.0)
    assert judged(scene, flown(scene, find_pilot(f"scripted:{style}"))) is Advice.SEEN


@pytest.mark.parametrize(
    ("pilot", "advice"),
    [(EARLY, Advice.FAINT), (Blind(), Advice.HIDDEN), (StraightPilot(), Advice.NOTHING)],
)
def test_who_teaches_nothing_is_told_why(
    asteroids: Callable[..., Scene], pilot: Pilot, advice: Advice
) -> None:
    scene = asteroids(density=4.0)
    assert judged(scene, flown(scene, pilot, flights=6, steps=300)) is advice


def test_too_early_nothing_is_said(asteroids: Callable[..., Scene]) -> None:
    scene = asteroids(density=4.0)
    moments = flown(scene, EARLY)
    for seconds in (39, 19):
        assert judged(scene, Decisions(*(part[: seconds * 15] for part in moments))) is None


def test_what_repeats_the_action_does_not_count_as_seeing_it(
    asteroids: Callable[..., Scene],
) -> None:
    scene = asteroids(density=4.0)
    moments = flown(scene, Blind(), flights=6, steps=300)
    own = np.einsum("kij,kj->ki", moments.frames, moments.actions)
    copies = moments._replace(states=np.hstack([moments.states, own]))
    assert judged(scene, copies) is Advice.HIDDEN


def test_it_remembers_the_latest_decisions_in_order() -> None:
    remembered = Remembered(3)
    for number in range(5):
        remembered.add(
            np.full((1, 2), number), np.zeros((1, 0)), np.full((1, 1), number), number // 2
        )
        held = remembered.all()
        assert held.actions[:, 0].tolist() == list(range(max(number - 2, 0), number + 1))
    assert held.states.tolist() == [[2, 2], [3, 3], [4, 4]]
    assert held.takes.tolist() == [1, 1, 2]
    remembered.add(np.zeros((1, 5)), np.zeros((1, 0)), np.zeros((1, 1)), 3)
    assert remembered.all().states.shape == (1, 5), (
        "what is perceived otherwise is not mixed with it"
    )


def test_it_thinks_now_and_then_and_says_one_thing(asteroids: Callable[..., Scene]) -> None:
    scene, pilot = asteroids(density=4.0), find_pilot("scripted:careful")
    work: list[Callable[[], None]] = []
    coach, said = Coach(scene.dt_s, work.append), []
    for seed in world_seeds(3, 2):
        run, memory = Run.new(scene, seed), pilot.begin(scene, [seed])
        for _ in range(400):
            actions, memory = pilot.act(scene, run.after, memory)
            coach.see(run, actions)
            said.append(coach.advice)
            while work:
                work.pop()()
            run.step(actions)
    assert said[: 40 * 15] == [None] * 40 * 15
    changes = [(one, other) for one, other in pairwise(said) if one is not other]
    assert changes == [(None, Advice.SEEN)]


@pytest.fixture
def store_url(tmp_path: Path) -> str:
    """One database is enough: nothing here is about stores."""
    return f"sqlite:///{tmp_path / 'store.db'}"


def test_a_stage_tells_what_the_coach_makes_of_it(stage: Stage, scene: Scene) -> None:
    stage.demonstrate(scene, 5, 0.0, 0.0)
    now = run(stage, 0.0, COUNTDOWN_S + 5.0, every=0.02)
    assert stage.status(now).coach is None
    now = run(stage, now, 28.0, every=0.02)
    assert stage.status(now).coach is Advice.NOTHING
    assert json.dumps(stage.status(now).coach) == '"nothing"'


def test_the_page_has_words_for_all_that_a_coach_says() -> None:
    page = Path(__file__).parents[2] / "web" / "js" / "coach.js"
    said = re.findall(r'^  (\w+): "', page.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(said) == sorted(Advice)
