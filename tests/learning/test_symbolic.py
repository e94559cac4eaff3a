"""Actions that are symbols: from a scene that declares them to a policy that plays."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

import evastudio
from evastudio.demonstrations.pairs import Pairs
from evastudio.errors import ConflictError, InvalidInputError
from evastudio.learning.fitting import fit_policy
from evastudio.learning.policy_files import load_policy, save_policy
from evastudio.live.inputs import HeldKeys
from evastudio.pilots.policy import PolicyPilot
from evastudio.workspace import Workspace
from evastudio.world.check import check_file
from evastudio.world.environment import SceneEnvironment
from evastudio.world.loading import load_scene_file
from evastudio.world.scene import Scene
from evastudio.world.spaces import Symbols

WALKER = Path(__file__).parent.parent / "scenes" / "walker.py"


@pytest.fixture
def walker() -> Scene:
    return load_scene_file(WALKER)()


def shown(scene: Scene, count: int = 200) -> Pairs:
    """What the scene's own intention does in new worlds."""
    worlds = scene.worlds(range(count))
    states = scene.perception().perceive(worlds).states
    takes, steps = np.arange(count) // 10, np.arange(count) % 10
    return Pairs(states, scene.intention(worlds), takes, steps)


def test_a_scene_of_symbols_keeps_the_rules_of_scenes() -> None:
    assert [finding for finding in check_file(WALKER) if finding.problem] == []


def test_it_is_a_gymnasium_environment_of_discrete_actions(walker: Scene) -> None:
    environment = SceneEnvironment(walker)
    assert environment.action_space == spaces.Discrete(5)
    check_env(environment, skip_render_check=True)
    with pytest.raises(InvalidInputError, match="hold 5, the code of no symbol"):
        environment.step(5)


def test_a_recorded_session_becomes_a_policy_that_arrives(workspace: Workspace) -> None:
    """By name only: record, fit without naming a learner, evaluate."""
    folder = workspace.root / "scenes"
    folder.mkdir()
    shutil.copy(WALKER, folder)
    recorded = evastudio.record(workspace, "walker", minutes=3.0)
    assert set(recorded["outcomes"]) <= {"arrived", "cut"}
    made = evastudio.fit(workspace, recorded["session"])
    assert made["learner"] == "voting"
    result = evastudio.evaluate(workspace, [made["policy"]], worlds=200, seed=5)
    assert result["policies"][made["policy"]]["success_rate"] > 0.97
    with pytest.raises(InvalidInputError, match="one of a set of symbols; choose voting"):
        evastudio.fit(workspace, recorded["session"], learner="svr")


def test_a_policy_of_symbols_comes_back_exactly(walker: Scene, tmp_path: Path) -> None:
    policy = fit_policy(shown(walker), walker, settings={"k": 3, "weights": "distance"})
    path = save_policy(policy, tmp_path / "one.safetensors")
    again = load_policy(path)
    asked = shown(walker, 400).states
    assert again.action == walker.action
    assert np.array_equal(again.act_states(asked), policy.act_states(asked))
    assert save_policy(again, tmp_path / "two.safetensors").read_bytes() == path.read_bytes()
    PolicyPilot(again).check(walker)


def test_codes_are_the_scenes_also_where_some_symbols_were_never_shown(walker: Scene) -> None:
    pairs = shown(walker)
    north = pairs.keep(np.isin(pairs.actions[:, 0], [2.0, 4.0]))
    policy = fit_policy(north, walker)
    assert set(policy.act_states(pairs.states)[:, 0]) == {2.0, 4.0}
    policy.learner.add_pairs(pairs.states, pairs.actions)
    assert set(policy.act_states(pairs.states)[:, 0]) >= {1.0, 2.0, 3.0, 4.0}


def test_learners_of_numbers_and_of_symbols_are_kept_apart(walker: Scene, asteroids: type) -> None:
    for learner in ("svr", "knn", "local-linear", "sampled"):
        with pytest.raises(InvalidInputError, match="choose voting"):
            fit_policy(shown(walker), walker, learner=learner)
    scene = asteroids()
    states = np.zeros((9, scene.perception().state.size))
    pairs = Pairs(states, np.zeros((9, 2)), np.zeros(9, np.int64), np.arange(9))
    with pytest.raises(InvalidInputError, match="which is numbers; choose svr or knn"):
        fit_policy(pairs, scene, learner="voting")


def test_a_policy_of_other_symbols_is_refused(walker: Scene) -> None:
    policy = fit_policy(shown(walker), walker)
    other = replace(policy, action=Symbols(("stand", "jump")))
    with pytest.raises(ConflictError, match="gives stand, jump"):
        PolicyPilot(other).check(walker)


def test_codes_are_checked_clipped_and_compared() -> None:
    space = Symbols(("stand", "left", "right"))
    assert space.clip(np.array([[-3.0], [1.4], [9.0]])).tolist() == [[0.0], [1.0], [2.0]]
    assert space.at(np.array([[0.0], [0.5], [1.0 - 2**-53]])).tolist() == [[0.0], [1.0], [2.0]]
    assert space.change(np.array([[0.0], [1.0]]), np.array([[0.0], [2.0]])).tolist() == [0.0, 1.0]
    assert space.check([[2], [0]], "actions").tolist() == [[2.0], [0.0]]
    for wrong in ([[3.0]], [[-1.0]], [[0.5]]):
        with pytest.raises(InvalidInputError, match="from 0 to 2 \\(stand, left, right\\)"):
            space.check(wrong, "actions")
    for wrong in ([0.0], [[np.nan]], [["left"]]):
        with pytest.raises(InvalidInputError, match="The actions"):
            space.check(wrong, "actions")


@pytest.mark.parametrize("names", [(), ("one",), ("a", "a"), ("a", ""), ("a", 3)])
def test_symbols_that_mean_nothing_are_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(InvalidInputError, match="symbols"):
        Symbols(names)


def test_a_held_key_chooses_its_symbol(walker: Scene) -> None:
    keys = HeldKeys(walker.controls, walker.action, walker.dt_s)
    assert keys.read(0.0, 0.5).tolist() == [[0.0]]
    keys.hold(["KeyW"], 0.5)
    assert keys.read(0.5, 1.0).tolist() == [[3.0]]
    keys.hold(["KeyW", "KeyN"], 1.4)
    assert keys.read(1.0, 1.5).tolist() == [[3.0]]
    keys.hold(["KeyN"], 1.5)
    assert keys.read(1.5, 2.0).tolist() == [[2.0]]


def test_sampled_votes_give_every_symbol_as_often_as_it_was_shown_there(walker: Scene) -> None:
    states = np.zeros((10, walker.perception().state.size))
    actions = np.array([[1.0]] * 7 + [[3.0]] * 3)
    pairs = Pairs(states, actions, np.zeros(10, dtype=int), np.arange(10))
    policy = fit_policy(pairs, walker, learner="sampled-voting", settings={"k": 10})
    asked = np.zeros((1000, states.shape[1]))
    drawn = policy.learner.decide(asked, (np.arange(1000) + 0.5) / 1000)[:, 0]
    assert np.count_nonzero(drawn == 1.0) == 700
    assert np.count_nonzero(drawn == 3.0) == 300
    assert (policy.act_states(asked) == 1.0).all()
