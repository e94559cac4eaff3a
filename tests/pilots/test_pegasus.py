"""PEGASUS: the same search from the same seed, scores that are those of the policy it gives."""

from __future__ import annotations

import itertools
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import evastudio
from evastudio.errors import InvalidInputError
from evastudio.learning.policy_files import load_policy, save_policy
from evastudio.pilots.pegasus import Pegasus
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import shipped
from evastudio.world.loading import load_scene_file
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds

SMALL = Pegasus(hidden=3, scenarios=3, horizon_s=6.0, population=6, rounds=3, seed=4)
BOTH = pytest.mark.parametrize("optimiser", ["cma-es", "hill-climbing"])


def searched(scene, settings, **given):
    told = []
    policy = settings.search(scene, watch=told.append, **given)
    return policy, told


@BOTH
def test_the_same_seed_finds_the_same_network(optimiser, asteroids):
    scene = asteroids(half_width=30.0)
    settings = replace(SMALL, optimiser=optimiser)
    (first, told), (second, _) = searched(scene, settings), searched(scene, settings)
    other, _ = searched(scene, replace(settings, seed=5))
    states = np.random.default_rng(0).normal(size=(20, first.state.size))
    assert np.array_equal(first.act_states(states), second.act_states(states))
    assert not np.array_equal(first.act_states(states), other.act_states(states))
    scores = [one.score for one in told]
    assert scores == sorted(scores)
    assert [one.trials for one in told] == [6, 12, 18]


@BOTH
def test_its_score_is_what_the_policy_gets_in_the_fixed_worlds(optimiser, asteroids, tmp_path):
    """Read from its file and flown as any policy is, it comes as far as the search said."""
    scene = asteroids(half_width=30.0)
    policy, told = searched(scene, replace(SMALL, optimiser=optimiser))
    pilot = PolicyPilot(load_policy(save_policy(policy, tmp_path / "found.safetensors")))
    came = np.zeros(SMALL.scenarios)

    def follow(alive, snapshot, _):
        came[alive] = scene.progress(snapshot)

    steps = round(SMALL.horizon_s / scene.dt_s)
    seeds = world_seeds(SMALL.seed, SMALL.scenarios)
    flown = roll_out(scene, pilot, seeds, max_steps=steps, watcher=follow)
    lost = np.isin(flown.outcomes, [scene.outcomes.index(name) for name in ("hit", "left")])
    score = came - SMALL.loss * lost - SMALL.calm * flown.turn
    assert score.mean() == pytest.approx(told[-1].score, abs=1e-9)


def test_hill_climbing_climbs(asteroids):
    settings = replace(SMALL, optimiser="hill-climbing", rounds=8, calm=0.0)
    _, told = searched(asteroids(half_width=30.0, density=8.0), settings)
    assert told[-1].score > told[0].score


def test_its_clocks_are_given(asteroids):
    ticks = itertools.count(0.0, 1.0)
    _, told = searched(
        asteroids(half_width=30.0), SMALL, clock=lambda: next(ticks), cpu=lambda: 7.0
    )
    assert [one.wall_s for one in told] == [1.0, 2.0, 3.0]
    assert {one.cpu_s for one in told} == {0.0}


def test_what_cannot_be_searched_is_refused(asteroids):
    crowd = load_scene_file(shipped() / "scenes" / "crowd.py")()
    with pytest.raises(InvalidInputError, match="scene 'crowd' has another kind"):
        SMALL.search(crowd)
    with pytest.raises(InvalidInputError, match="must be one of cma-es, hill-climbing"):
        Pegasus(optimiser="luck")
    with pytest.raises(InvalidInputError, match="rounds is 0"):
        Pegasus(rounds=0)
    with pytest.raises(InvalidInputError, match="CMA-ES needs 4"):
        Pegasus(population=3)
    with pytest.raises(InvalidInputError, match="horizon_s is nan"):
        Pegasus(horizon_s=float("nan"))


def test_a_search_is_a_command_and_its_file_says_which(tmp_path):
    words = ["search", "asteroids", "--hidden", "2", "--scenarios", "2", "--horizon-s", "2.0"]
    words += ["--population", "6", "--rounds", "2", "--out", "found.safetensors"]
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        subprocess.run(
            [sys.executable, "-m", "evastudio", *words, "--workspace", "."],
            check=True,
            cwd=tmp_path / folder,
            capture_output=True,
        )
        policy = load_policy(tmp_path / folder / "found.safetensors")
        words = [*policy.made_by.split()[1:], "--jobs", "2"]
    assert words[:2] == ["search", "asteroids"]
    assert len(policy.extra["pegasus"]["curve"]) == 2
    assert policy.pairs == 0
    first = load_policy(tmp_path / "one" / "found.safetensors")
    assert np.array_equal(first.learner.inner_, policy.learner.inner_)


def test_what_was_found_flies_beside_astar(workspace):
    place = replace(SMALL, rounds=1)
    evastudio.search(workspace, "asteroids", place, name="found", clock=lambda: 0.0)
    result = evastudio.evaluate(workspace, ["astar", "found"], worlds=2, options={"half_width": 30})
    assert result["policies"]["astar"]["succeeded"] == 2
    assert set(result["policies"]) == {"astar", "found"}
