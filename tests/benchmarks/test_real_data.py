"""What `benchmarks/real` does to recordings, on tiny ones written here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.real.closed_loop import chunks
from benchmarks.real.faults import with_delay, with_outliers
from benchmarks.real.push import GOAL, PERCEPTIONS, BlockPerception, Perception
from benchmarks.real.recordings import data_folder, pairs_until, read_arrays
from benchmarks.real.walking import (
    ConstantVelocity,
    StraightToGoal,
    displacement,
    perceive,
    read_experiment,
    walkers_as_pairs,
)
from benchmarks.report import write_section
from evastudio.demonstrations.pairs import Pairs


def two_takes() -> Pairs:
    actions = np.arange(16.0).reshape(8, 2)
    return pairs_until(np.arange(8.0)[:, None], actions, np.array([5, 8]))


def worlds(count: int) -> np.ndarray:
    rng = np.random.default_rng(1)
    return np.column_stack([rng.uniform(100, 400, (count, 4)), rng.uniform(0, 6.28, count)])


def test_demonstrations_end_where_the_file_says() -> None:
    pairs = two_takes()
    assert pairs.takes.tolist() == [0] * 5 + [1] * 3
    assert pairs.steps.tolist() == [0, 1, 2, 3, 4, 0, 1, 2]


def test_another_recording_than_the_expected_one_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "short.npz", state=np.zeros((3, 5)))
    with pytest.raises(SystemExit, match="another recording"):
        read_arrays(tmp_path / "short.npz", {"state": (4, 5)})
    with pytest.raises(SystemExit, match="cannot be read"):
        read_arrays(tmp_path / "none.npz", {"state": (4, 5)})


def test_a_missing_folder_is_named_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("EVASTUDIO_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(SystemExit, match="EVASTUDIO_DATA"):
        data_folder()


def test_outliers_replace_the_share_asked_for_and_stay_in_range() -> None:
    pairs = pairs_until(np.zeros((100, 1)), np.linspace(0, 1, 200).reshape(100, 2), np.array([100]))
    spoilt = with_outliers(pairs, 0.1, np.random.default_rng(0))
    assert int((spoilt.actions != pairs.actions).any(axis=1).sum()) == 10
    assert (spoilt.actions >= 0).all()
    assert (spoilt.actions <= 1).all()
    assert (spoilt.states == pairs.states).all()


def test_a_delay_stays_inside_each_take() -> None:
    late = with_delay(two_takes(), 2)
    assert late.states[:, 0].tolist() == [2, 3, 4, 7]
    assert late.actions[:, 0].tolist() == [0, 2, 4, 10]


@pytest.mark.parametrize("perception", PERCEPTIONS, ids=lambda one: one.name)
def test_actions_turned_to_the_own_frame_and_back_are_the_same(perception: Perception) -> None:
    seen = worlds(50)
    percept = perception.perceive(seen)
    targets = np.random.default_rng(2).uniform(0, 512, (50, 2))
    own = perception.to_own(percept, targets)
    np.testing.assert_allclose(perception.to_world(percept, own), targets, atol=1e-9)


def test_the_block_sees_the_same_in_a_world_mirrored_about_the_goal() -> None:
    seen = worlds(50)
    axis = GOAL[2] + np.pi / 2  # the goal's mirror axis is the y axis of its frame
    mirror = np.array([[np.cos(2 * axis), np.sin(2 * axis)], [np.sin(2 * axis), -np.cos(2 * axis)]])
    other = seen.copy()
    for at in (0, 2):
        other[:, at : at + 2] = (seen[:, at : at + 2] - GOAL[:2]) @ mirror.T + GOAL[:2]
    other[:, 4] = 2 * GOAL[2] - seen[:, 4]
    view = BlockPerception()
    np.testing.assert_allclose(view.perceive(other).states, view.perceive(seen).states, atol=1e-9)


def test_chunks_hold_the_last_target_of_a_demonstration() -> None:
    pairs = two_takes()
    seen, targets = np.zeros((8, 5)), np.arange(16.0).reshape(8, 2)
    chunked = chunks(pairs, Perception(), seen, targets, 3).actions
    assert chunked[3].tolist() == [6, 7, 8, 9, 8, 9]
    assert chunked[5].tolist() == [10, 11, 12, 13, 14, 15]


def walk(tmp_path: Path) -> Path:
    lines = ["# source=made here fps=25 kept every 10 frames (0.400s) columns: frame ped x_m y_m"]
    for step in range(30):
        lines += [f"{10 * step} 1 {0.4 * step:.3f} 0.0", f"{10 * step} 7 {0.4 * step:.3f} 1.0"]
    path = tmp_path / "walk.txt"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_walkers_are_read_with_their_rate_and_goals(tmp_path: Path) -> None:
    experiment = read_experiment(walk(tmp_path))
    assert experiment.positions.shape == (30, 2, 2)
    assert experiment.dt_s == 0.4
    np.testing.assert_allclose(experiment.goals, [[11.6, 0.0], [11.6, 1.0]])


def test_who_walks_straight_changes_nothing_and_is_foretold(tmp_path: Path) -> None:
    experiment = read_experiment(walk(tmp_path))
    recording = walkers_as_pairs((experiment, experiment))
    assert len(recording.pairs) == 2 * 2 * 28
    assert recording.pairs.steps.max() == 27
    assert len(np.unique(recording.pairs.takes)) == 4
    np.testing.assert_allclose(recording.pairs.actions, 0.0, atol=1e-9)
    for walker in (ConstantVelocity(), StraightToGoal()):
        np.testing.assert_allclose(displacement(walker, experiment), 0.0, atol=1e-9)


def test_a_walker_alone_sees_nobody() -> None:
    states, _ = perceive(np.zeros((1, 2)), np.array([[1.0, 0.0]]), np.array([[0.0, 9.0]]))
    np.testing.assert_allclose(states[0], [0.0, -1.0, 5.0, *[0.0] * 12], atol=1e-12)


def test_sections_are_replaced_and_leave_the_rest_alone(tmp_path: Path) -> None:
    path = tmp_path / "results.md"
    write_section(path, "one", "first")
    write_section(path, "two", "second")
    write_section(path, "one", "newer")
    text = path.read_text(encoding="utf-8")
    assert "first" not in text
    assert text.index("newer") < text.index("second")
    assert text.count("<!-- one -->") == 1
