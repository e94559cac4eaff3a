"""The asteroid field against the paper's figures and against arithmetic."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.pilots.straight import StraightPilot
from evastudio.world.check import check_scene
from evastudio.world.rocks import in_cells
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene, world_seeds
from evastudio.world.snapshot import Snapshot

Kind = Callable[..., Scene]


def test_it_keeps_the_rules_of_scenes(asteroids: type[Scene]) -> None:
    findings = check_scene(asteroids, seed=3)
    assert len(findings) == 9
    assert [found for found in findings if found.problem] == []


def test_a_straight_crossing_takes_540_decisions_and_36_seconds(asteroids: Kind) -> None:
    scene = asteroids(density=0.1)
    result = roll_out(scene, StraightPilot(), world_seeds(0, 30))
    crossed = result.outcomes == scene.outcomes.index("crossed")
    assert crossed.sum() > 20
    assert (result.steps[crossed] == 540).all()
    assert scene.dt_s * 540 == pytest.approx(36.0)


@pytest.mark.parametrize("density", [0.5, 1.0, 2.0])
def test_density_is_the_expected_number_of_hits(asteroids: Kind, density: float) -> None:
    scene = asteroids(density=density)
    worlds = 400
    result = roll_out(scene, StraightPilot(), world_seeds(5, worlds))
    share = float((result.outcomes == scene.outcomes.index("crossed")).mean())
    expected = np.exp(-density)
    assert abs(share - expected) < 4.0 * np.sqrt(expected * (1 - expected) / worlds)


def test_each_way_to_end_is_told(asteroids: Kind) -> None:
    scene = asteroids()
    start = scene.worlds([1])
    rock = start["rocks"][0, 100]

    def at(position: np.ndarray, steps: int = 0) -> str:
        moved = start.after(position=position[None, :], steps=np.array([steps]))
        return scene.outcomes[int(scene.outcome(moved)[0])]

    assert at(np.zeros(3)) == "running"
    assert at(rock) == "hit"
    assert at(np.array([10.0, 100.5, 0.0])) == "left"
    assert at(np.array([10.0, 0.0, -100.5])) == "left"
    assert at(np.array([5.0, 0.0, 0.0]), steps=1350) == "late"
    assert at(np.array([360.0, 0.0, 0.0])) in {"crossed", "hit"}


def test_an_action_beyond_the_limit_turns_as_far_as_the_limit(asteroids: Kind) -> None:
    scene = asteroids()
    turned = scene.step(scene.worlds([1]), np.array([[1.0, -1.0]]))
    assert turned["heading"] == pytest.approx(np.radians([[6.0, -6.0]]))


def test_a_world_depends_on_its_own_seed_alone(asteroids: Kind) -> None:
    scene = asteroids(density=1.0)
    together = scene.worlds([7, 8, 9])
    assert np.array_equal(together["rocks"][1], scene.worlds([8])["rocks"][0])
    assert not np.array_equal(together["rocks"][0], together["rocks"][1])


def test_the_papers_state_is_the_papers(asteroids: Kind) -> None:
    scene = asteroids(density=1.0)
    start = scene.worlds([4])
    position, heading = np.array([[100.0, 3.0, -2.0]]), np.array([[0.2, -0.1]])
    moment = start.after(position=position, heading=heading)
    separations = position[0] - start["rocks"][0]
    nearest = separations[np.argsort(np.linalg.norm(separations, axis=1))[:2]]
    states = scene.perception("paper").perceive(moment).states
    assert states[0] == pytest.approx(np.concatenate([[0.2, -0.1], nearest.ravel()]))


def test_the_canonical_view_is_the_same_from_every_side(asteroids: Kind) -> None:
    """Turning the whole world about the flight axis, or mirroring it, changes no state."""
    scene = asteroids(density=4.0)
    view = scene.perception("canonical")
    start = scene.worlds([11]).after(position=np.array([[50.0, 0.0, 0.0]]))
    percept = view.perceive(start)
    action = np.array([[0.03, -0.01]])
    for turn in (np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[1.0, 0.0], [0.0, -1.0]])):
        rocks = start["rocks"].copy()
        rocks[:, :, 1:] = rocks[:, :, 1:] @ turn.T
        fixed = in_cells(rocks, 360.0, start["half"][0])
        other = view.perceive(Snapshot(fixed, start.moving))
        assert other.states == pytest.approx(percept.states)
        own = view.to_own(percept.frame, action)
        assert view.to_own(other.frame, action @ turn.T) == pytest.approx(own)


def test_options_out_of_range_and_unknown_ones_are_refused(asteroids: Kind) -> None:
    with pytest.raises(InvalidInputError, match=r"must be a number from 0\.1 to 10"):
        asteroids(density=99.0)
    with pytest.raises(InvalidInputError, match="density"):
        asteroids(density=float("nan"))
    with pytest.raises(NotFoundError, match="Did you mean 'density'"):
        asteroids(densty=1.0)
    with pytest.raises(NotFoundError, match="canonical"):
        asteroids().perception("canonicle")
