"""Pilots: the same world gives the same flight, whatever flies beside it."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from evastudio.demonstrations.pairs import join_pairs, perceive_take
from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.learning.fitting import fit_policy
from evastudio.pilots.chance import normals, uniforms
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import ScriptedPilot, find_pilot, pilot_names
from evastudio.pilots.traits import STYLES, Traits
from evastudio.world.rollout import roll_out
from evastudio.world.scene import world_seeds
from evastudio.world.snapshot import stack

SEEDS = world_seeds(5, 6)


def demonstrated(scene, pilot, perception, seeds=SEEDS[:2]):
    parts = []
    for take, seed in enumerate(seeds):
        seen, done = [], []
        roll_out(
            scene,
            pilot,
            [seed],
            max_steps=120,
            watcher=lambda _, snapshot, actions, seen=seen, done=done: (
                seen.append(snapshot),
                done.append(actions[0]),
            ),
        )
        parts.append(perceive_take(scene.perception(perception), stack(seen), np.array(done), take))
    return join_pairs(parts)


@pytest.fixture(scope="module")
def flown():
    """A cache of policies: learner and perception to pilot."""
    return {}


def pilot_of(name, scene, flown):
    if not name.startswith("policy:"):
        return find_pilot(name)
    if name not in flown:
        _, learner, perception = name.split(":")
        pairs = demonstrated(scene, find_pilot("scripted:human"), perception)
        flown[name] = PolicyPilot(fit_policy(pairs, scene, perception, learner))
    return flown[name]


def tracks(scene, pilot, seeds, steps=90):
    """Every world's headings and actions, step by step."""
    kept = [[] for _ in seeds]

    def watch(alive, snapshot, actions):
        for row, world in enumerate(alive):
            kept[world].append((*snapshot["heading"][row], *actions[row]))

    rollout = roll_out(scene, pilot, seeds, max_steps=steps, watcher=watch)
    return [np.array(track) for track in kept], rollout


POLICIES = [
    "policy:knn:canonical",
    "policy:svr:canonical",
    "policy:svr:paper",
    "policy:knn:paper",
    "policy:local-linear:canonical",
    "policy:sampled:canonical",
    "policy:mlp:canonical",
]


@pytest.mark.parametrize("name", [*pilot_names(), *POLICIES])
def test_a_world_in_a_batch_is_that_world_alone_bit_for_bit(name, asteroids, flown):
    scene = asteroids(density=8.0)
    pilot = pilot_of(name, scene, flown)
    together, rollout = tracks(scene, pilot, SEEDS)
    for number, seed in enumerate(SEEDS):
        alone, single = tracks(scene, pilot, [seed])
        assert np.array_equal(alone[0], together[number])
        assert single.outcomes[0] == rollout.outcomes[number]
        assert single.steps[0] == rollout.steps[number]
        assert single.turn[0] == rollout.turn[number]


@pytest.mark.parametrize("name", ["canonical", "paper"])
def test_states_of_a_batch_are_those_of_each_world_alone(name, asteroids):
    scene = asteroids()
    view = scene.perception(name)
    snapshots = []
    roll_out(
        scene,
        find_pilot("scripted:human"),
        SEEDS,
        max_steps=60,
        watcher=lambda _, snapshot, __: snapshots.append(snapshot),
    )
    for snapshot in snapshots[::6]:
        whole = view.perceive(snapshot)
        for world in range(snapshot.worlds):
            one = view.perceive(snapshot.take(slice(world, world + 1)))
            assert np.array_equal(one.states[0], whole.states[world])
            assert np.array_equal(one.frame[0], whole.frame[world])


@pytest.mark.parametrize("name", ["canonical", "paper"])
def test_actions_survive_the_way_to_the_own_frame_and_back(name, asteroids):
    scene = asteroids()
    view = scene.perception(name)
    snapshot = scene.worlds(SEEDS).after(
        position=np.tile([60.0, 5.0, -9.0], (6, 1)), heading=np.full((6, 2), 0.2)
    )
    frame = view.perceive(snapshot).frame
    actions = np.random.default_rng(0).uniform(-0.1, 0.1, (6, 2))
    back = view.to_world(frame, view.to_own(frame, actions))
    assert np.allclose(back, actions, rtol=0, atol=1e-15)


def test_the_two_nearest_rocks_are_the_two_nearest_of_all(asteroids):
    for density in (0.1, 4.0):
        scene = asteroids(density=density)
        snapshot = scene.worlds(SEEDS)
        snapshot = snapshot.after(position=np.tile([200.0, 20.0, 1.0], (6, 1)))
        states = scene.perception("paper").perceive(snapshot).states
        for world in range(6):
            away = snapshot["position"][world] - snapshot["rocks"][world]
            near = away[np.argsort((away**2).sum(axis=1))[:2]]
            assert np.allclose(states[world, 2:], near.reshape(-1), rtol=0, atol=1e-12)


def test_scripted_styles_do_what_their_traits_say(asteroids):
    scene = asteroids()
    perfect = ScriptedPilot(Traits())
    for changed in (
        {"tremor": 0.2},
        {"smoothing": 0.5},
        {"mistakes_per_minute": 600.0},
        {"indecision_per_minute": 600.0},
        {"keys": True},
        {"delay_steps": 4},
        {"intention": {"berth": 2.0}},
    ):
        calm, _ = tracks(scene, perfect, SEEDS[:2], 80)
        other, _ = tracks(scene, ScriptedPilot(Traits(**changed)), SEEDS[:2], 80)
        assert not np.array_equal(calm[0], other[0]), changed


def test_full_anticipation_makes_up_for_a_delay(asteroids):
    """The scene is known, and so is what the own hand did: nothing else moves in it."""
    scene = asteroids()
    prompt, _ = tracks(scene, ScriptedPilot(Traits()), SEEDS[:3])
    late = Traits(delay_steps=4, delay_jitter_steps=2, anticipation=1.0)
    foreseen, _ = tracks(scene, ScriptedPilot(late), SEEDS[:3])
    for one, other in zip(prompt, foreseen, strict=True):
        assert np.allclose(one, other, rtol=0, atol=1e-9)


def test_keys_move_no_faster_than_their_ramp(asteroids):
    scene = asteroids(density=8.0)
    flight, _ = tracks(scene, find_pilot("scripted:keys"), SEEDS[:3])
    pace = scene.dt_s / scene.controls[0].ramp_s * scene.action.high[0]
    for track in flight:
        assert np.abs(np.diff(track[:, 2:], axis=0)).max() <= pace + 1e-12
        assert (np.abs(track[:, 2:]) > 0).any()


def test_chance_is_even_and_follows_from_seed_step_and_channel():
    seeds = np.arange(20_000, dtype=np.uint64)
    step = np.zeros(20_000, dtype=np.int64)
    numbers = uniforms(seeds, step, 1, 2)
    assert abs(numbers.mean() - 0.5) < 0.01
    assert abs(np.corrcoef(numbers.T)[0, 1]) < 0.03
    assert abs(np.corrcoef(numbers[:, 0], uniforms(seeds, step + 1, 1)[:, 0])[0, 1]) < 0.03
    assert abs(np.corrcoef(numbers[:, 0], uniforms(seeds, step, 2)[:, 0])[0, 1]) < 0.03
    assert abs(normals(seeds, step, 3).std() - 1.0) < 0.02
    assert np.array_equal(uniforms(seeds[7:8], step[7:8], 1, 2)[0], numbers[7])


def test_a_sampled_policy_is_lucky_by_seed_and_step_alone(asteroids, flown):
    """Two worlds alike in all but their seeds part; the same seed does the same again."""
    scene = asteroids()
    pilot = pilot_of("policy:sampled:canonical", scene, flown)
    learner = deepcopy(pilot.policy.learner).set_params(k=40, link=1e-6)  # each pair its own way
    pilot = PolicyPilot(replace(pilot.policy, learner=learner.prepare()))
    start = scene.worlds([SEEDS[0]] * 3)
    memory = pilot.begin(scene, [SEEDS[0], SEEDS[1], SEEDS[0]])
    first, memory = pilot.act(scene, start, memory)
    second, _ = pilot.act(scene, start, memory)
    assert np.array_equal(first[0], first[2])
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first[0], second[0])


def test_an_unknown_pilot_or_trait_gets_a_hint():
    with pytest.raises(NotFoundError, match="Did you mean 'scripted:careful'"):
        find_pilot("scripted:carefull")
    with pytest.raises(NotFoundError, match="Did you mean 'tremor'"):
        find_pilot("scripted:human", tremors=1.0)
    with pytest.raises(NotFoundError, match="no trait 'tremor' of pilot 'straight'"):
        find_pilot("straight", tremor=1.0)
    with pytest.raises(InvalidInputError, match="'tremor' is -1"):
        find_pilot("scripted:human", tremor=-1)
    with pytest.raises(InvalidInputError, match="'smoothing' is 2"):
        find_pilot("scripted:human", smoothing=2)
    assert find_pilot("scripted:human", tremor=0.5).traits.tremor == 0.5
    assert STYLES["human"].tremor != 0.5


def test_a_policy_of_another_scene_or_version_is_refused(asteroids, flown):
    scene = asteroids()
    policy = pilot_of("policy:knn:canonical", scene, flown).policy
    PolicyPilot(policy).check(scene)
    for scene_of, says in (
        ({"name": "crowd", "version": 1, "options": {}}, "made for scene 'crowd'"),
        ({"name": "asteroids", "version": 99, "options": {}}, "version 99"),
    ):
        with pytest.raises(ConflictError, match=says):
            roll_out(scene, PolicyPilot(replace(policy, scene=scene_of)), SEEDS[:1])
    with pytest.raises(ConflictError, match="perceives through 'sonar'"):
        PolicyPilot(replace(policy, perception="sonar")).check(scene)
    with pytest.raises(ConflictError, match="has changed since"):
        PolicyPilot(replace(policy, perception="paper")).check(scene)
