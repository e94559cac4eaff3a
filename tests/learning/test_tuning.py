"""Tuning: settings chosen on whole takes, and a report that claims what was measured."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.learning.candidates import GRIDS, Candidate
from evastudio.learning.holdout import take_folds
from evastudio.learning.perceived import Perceived
from evastudio.learning.trials import Examiner, Trial, choose, is_better
from evastudio.learning.tuning import tune
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Percept, Perception, Scene
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array, Box
from evastudio.world.spaces import Field as Component

WALKER = Path(__file__).parent.parent / "scenes" / "walker.py"


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(4)


@pytest.fixture(scope="session")
def scene(asteroids: Callable[..., Scene]) -> Scene:
    return asteroids()


def shown(
    rng: np.random.Generator,
    rule: Callable[[Array], Array],
    takes: int = 8,
    each: int = 60,
    noise: float = 0.02,
) -> Pairs:
    """Takes of states in a square answered by `rule`, with a little noise."""
    count = takes * each
    states = rng.uniform(-1.0, 1.0, (count, 2))
    actions = 0.05 * (rule(states) + noise * rng.normal(size=(count, 2)))
    numbers = np.repeat(np.arange(takes) * 3 + 1, each)
    return Pairs(states, actions, numbers, np.tile(np.arange(each), takes))


def smooth(states: Array) -> Array:
    return np.stack([np.sin(2.0 * states[:, 0]), states.sum(axis=1) / 2.0], axis=1)


def checkerboard(states: Array) -> Array:
    field = np.sign(np.sin(9.0 * states[:, 0]) * np.sin(9.0 * states[:, 1]))
    return np.stack([field, -field], axis=1)


def unknowable(states: Array) -> Array:
    return np.zeros_like(states)


def test_a_smooth_mapping_gets_the_smooth_learner(rng: np.random.Generator, scene: Scene) -> None:
    report = tune(shown(rng, smooth), scene)
    assert report.chosen.learner == report.recommended == "svr"
    assert report.roughness is not None
    assert report.roughness < 1.0
    assert report.beats_constant
    assert report.beats_linear
    assert report.error < report.linear < report.constant
    assert "Smooth suits that" in " ".join(report.sentences)


def test_a_rough_mapping_gets_the_nearest_neighbours(
    rng: np.random.Generator, scene: Scene
) -> None:
    report = tune(shown(rng, checkerboard, each=150), scene)
    assert report.chosen.learner == report.recommended == "knn"
    assert report.roughness is not None
    assert report.roughness > 1.0
    assert report.more_would_help
    assert "Exact suits that" in " ".join(report.sentences)


def test_where_nothing_can_be_learned_the_defaults_stay_and_the_report_says_so(
    rng: np.random.Generator, scene: Scene
) -> None:
    report = tune(shown(rng, unknowable), scene)
    assert report.chosen == Candidate("svr")
    assert not report.beats_constant
    assert not report.more_would_help
    assert "not reliably closer" in report.sentences[0]


def test_the_report_repeats_whatever_the_number_of_threads(
    rng: np.random.Generator, scene: Scene
) -> None:
    pairs = shown(rng, smooth, takes=5, each=30)
    once, again = (tune(pairs, scene, n_jobs=jobs).to_json() for jobs in (1, 2))
    assert once == again
    assert json.loads(json.dumps(once)) == once


def test_two_takes_suffice_and_one_does_not(rng: np.random.Generator, scene: Scene) -> None:
    report = tune(shown(rng, smooth, takes=2), scene)
    assert report.chosen.learner in GRIDS
    assert set(report.by_take) == {1, 4}
    assert any("only 2 takes" in sentence for sentence in report.sentences)
    with pytest.raises(InvalidInputError, match="only one take"):
        tune(shown(rng, smooth, takes=1), scene)
    few = tune(shown(rng, smooth, takes=2, each=12), scene)
    assert {row.candidate.learner for row in few.trials} == {"svr", "knn"}
    with pytest.raises(InvalidInputError, match="only 5 pairs to learn from"):
        tune(shown(rng, smooth, takes=2, each=5), scene)


def test_pairs_that_are_no_numbers_are_refused(rng: np.random.Generator, scene: Scene) -> None:
    pairs = shown(rng, smooth, takes=3)
    pairs.states[4, 0] = np.nan
    with pytest.raises(InvalidInputError, match="states of the pairs"):
        tune(pairs, scene)


def test_actions_that_never_change_are_no_trouble(rng: np.random.Generator, scene: Scene) -> None:
    still = shown(rng, unknowable, takes=3, each=20, noise=0.0)
    report = tune(still, scene)
    assert report.chosen == Candidate("svr")
    assert report.error == report.constant == 0.0


def test_one_learner_can_be_tuned_alone_and_only_one_that_exists(
    rng: np.random.Generator, scene: Scene
) -> None:
    pairs = shown(rng, smooth, takes=4, each=30)
    report = tune(pairs, scene, "knn")
    assert {row.candidate.learner for row in report.trials} == {"knn"}
    assert report.roughness is None
    with pytest.raises(NotFoundError, match="auto"):
        tune(pairs, scene, "oracle")


def test_every_grid_holds_the_defaults() -> None:
    for learner, grid in GRIDS.items():
        for setting, values in grid.items():
            assert Candidate(learner).value(setting) in values


def test_conflicts_are_looked_for_among_the_takes_learned_from_only(
    rng: np.random.Generator, scene: Scene
) -> None:
    """A take that contradicts all the others is a conflict to them, but does not make them one."""
    pairs = shown(rng, smooth, takes=4, noise=0.0)
    wild = pairs.takes == 1
    pairs.actions[wild] *= -3.0
    seen = []
    examiner = Examiner(pairs, scene, n_jobs=1, progress=lambda share, doing: seen.append(share))
    (trial,) = examiner.run([Candidate("knn", threshold=0.3)])
    assert seen == [1.0]
    by_take = trial.held_out.by_take
    assert by_take[1] > 2 * by_take[4]
    for held, used in zip(
        examiner.folds, (examiner._used(0.3, fold, None) for fold in range(4)), strict=True
    ):
        assert used is not None
        assert not used[held].any()
        if held[wild].all():
            assert used[~held].all()
    assert len(trial.wrong) == len(pairs)


def trial(candidate: Candidate, wrong: Array, takes: Array) -> Trial:
    return Trial(candidate, wrong, takes.astype(np.int64), False)


def test_settings_leave_their_defaults_only_where_the_takes_agree(
    rng: np.random.Generator,
) -> None:
    takes = np.repeat(np.arange(6), 100)
    usual = trial(Candidate("svr"), np.full(600, 1.0), takes)
    lucky = trial(Candidate("svr", {"C": 3.0}), np.where(takes == 0, 0.2, 1.0), takes)
    steady = trial(Candidate("svr", {"C": 100.0}), np.full(600, 0.9) + takes / 1e3, takes)
    little = trial(Candidate("svr", {"C": 10.0}), np.full(600, 0.999) - takes / 1e6, takes)
    assert lucky.wrong.mean() < steady.wrong.mean() + 0.1
    assert choose([usual, lucky, little]) is usual
    assert choose([usual, steady]) is steady
    assert choose([usual, usual, little]) is usual


def test_a_gain_on_a_few_slips_alone_does_not_count() -> None:
    takes = np.repeat(np.arange(6), 100)
    slips = np.tile(np.arange(100) < 5, 6)
    usual = trial(Candidate("svr"), np.where(slips, 20.0, 0.1), takes)
    other = trial(Candidate("svr", {"C": 3.0}), np.where(slips, 15.0, 0.2), takes)
    assert other.wrong.mean() < usual.wrong.mean()
    assert not is_better(usual, other)


class Turned(Perception):
    """Sees the same with noise, and gives actions the other way round."""

    name = "turned"
    summary = ""
    state = Box((Component("x", "", -9.0, 9.0), Component("y", "", -9.0, 9.0)))

    def perceive(self, snapshot: Snapshot) -> Percept:
        raise NotImplementedError

    def to_world(self, frame: Array, actions: Array) -> Array:
        return actions * frame


class Clear(Turned):
    name = "clear"


def test_another_perception_is_named_where_it_tells_more(
    rng: np.random.Generator, scene: Scene
) -> None:
    pairs = shown(rng, smooth)
    sign = rng.choice([-1.0, 1.0], (len(pairs), 1))
    blurred = pairs.states + 0.7 * rng.normal(size=pairs.states.shape)
    turned = Pairs(blurred, pairs.actions * sign, pairs.takes, pairs.steps)
    upright = Pairs(blurred, pairs.actions, pairs.takes, pairs.steps)
    ones = np.ones((len(pairs), 1))
    views = [Perceived(Turned(), upright, ones), Perceived(Clear(), pairs, ones)]
    report = tune(upright, scene, "knn", views=views)
    assert report.better_perception == "clear"
    assert any("'clear' tells more" in sentence for sentence in report.sentences)
    views = [Perceived(Clear(), pairs, ones), Perceived(Turned(), turned, sign)]
    report = tune(pairs, scene, "knn", views=views)
    assert report.better_perception is None
    assert list(report.perceptions) == ["clear", "turned"]
    part = Perceived(Turned(), turned.keep(turned.steps > 3), sign[turned.steps > 3])
    assert tune(pairs, scene, "knn", views=[views[0], part]).perceptions == {}


def test_symbols_are_judged_by_the_share_of_wrong_ones(rng: np.random.Generator) -> None:
    walker = load_scene_file(WALKER)()
    worlds = walker.worlds(range(200))
    states, codes = walker.perception().perceive(worlds).states, walker.intention(worlds)
    pairs = Pairs(states, codes, np.arange(200) // 25, np.arange(200) % 25)
    report = tune(pairs, walker)
    assert report.symbols
    assert report.chosen.learner == "voting"
    assert 0.0 <= report.error < report.constant < 1.0
    assert report.roughness is None
    assert "chose as you did in" in report.sentences[0]
    with pytest.raises(NotFoundError, match="voting"):
        tune(pairs, walker, "svr")


def test_takes_are_held_out_whole(rng: np.random.Generator) -> None:
    pairs = shown(rng, smooth, takes=7)
    for held in take_folds(pairs.takes):
        assert not set(pairs.takes[held]) & set(pairs.takes[~held])


@pytest.mark.parametrize(
    ("sizes", "threshold"), [((22, 22, 18), None), ((200, 200, 6), None), ((60, 60, 60), 0.3)]
)
def test_takes_too_few_or_too_short_to_be_halved_are_tuned_all_the_same(
    rng: np.random.Generator, scene: Scene, sizes: tuple[int, ...], threshold: float | None
) -> None:
    whole = shown(rng, smooth, takes=3, each=max(sizes))
    pairs = whole.keep(whole.steps < np.repeat(sizes, max(sizes)))
    report = tune(pairs, scene, "local-linear", threshold=threshold)
    halved = threshold is not None
    assert len(report.learning) == 1 + halved
    assert any("half of them" in sentence for sentence in report.sentences) == halved


def test_a_learner_that_needs_more_pairs_than_there_are_says_so(
    rng: np.random.Generator, scene: Scene
) -> None:
    with pytest.raises(InvalidInputError, match="only 15 pairs to learn from, and at least 40"):
        tune(shown(rng, smooth, takes=2, each=15), scene, "local-linear")
