"""The pieces of the reproduction study: fields that differ, states between, and a demonstrator."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import reproduction
from benchmarks.atlas import Atlas, report
from benchmarks.plain_state import DENSITIES, Cell, Found, references, variant, whole_map
from benchmarks.reproduction import demonstrator, itself, measured, shown
from benchmarks.two_nearest import LADDER
from evastudio.world.rollout import roll_out
from evastudio.world.scene import Scene


def scene(**constants: str) -> Scene:
    return variant(tuple(constants.items()))(density=2.0, half_width=30.0)


def test_a_constant_is_changed_in_one_field_only() -> None:
    seeds = [1]
    fewer = scene(ROCK_RADIUS="6.0").worlds(seeds)["rocks"].shape[1]
    assert 0 < fewer < scene().worlds(seeds)["rocks"].shape[1]
    assert scene(TURN="np.radians(3.0)").action.high[0] == pytest.approx(np.radians(3.0))
    assert scene().action.high[0] == pytest.approx(np.radians(6.0))


def test_a_constant_that_is_none_is_refused() -> None:
    with pytest.raises(AssertionError, match="WARP is no constant"):
        variant((("WARP", "9"),))


def test_without_walls_nobody_is_lost_outside() -> None:
    seeds = list(range(12))
    outcomes = {}
    for walls in ("True", "False"):
        field = scene(WALLS=walls)
        lost = field.outcomes.index("left")
        away = field.worlds(seeds)
        away = away.after(position=away["position"] + (0.0, 80.0, 0.0))
        outcomes[walls] = (field.outcome(away) == lost).mean()
    assert outcomes == {"True": 1.0, "False": 0.0}


def test_who_answers_to_the_two_nearest_answers_to_the_paper_state_alone() -> None:
    field = scene(WALLS="False")
    flown = roll_out(field, demonstrator("two nearest"), list(range(8)))
    assert (flown.outcomes == field.outcomes.index("crossed")).mean() >= 0.75
    moment = field.worlds(list(range(8)))
    nearest = field.intention(moment, two_nearest=1.0)
    far_gone = moment.after(steps=moment["steps"] + 99)
    assert np.array_equal(nearest, field.intention(far_gone, two_nearest=1.0))


@pytest.mark.parametrize("changes", LADDER, ids=", ".join)
def test_states_between_hold_the_orientation_and_two_rocks(changes: tuple[str, ...]) -> None:
    field = scene()
    worlds = field.worlds([3, 4])
    worlds = worlds.after(
        position=worlds["position"] + (60.0, 0.0, 0.0), heading=np.full((2, 2), 0.4)
    )
    plain = field.perception("paper").perceive(worlds).states
    states = field.perception(", ".join(changes)).perceive(worlds).states
    assert states.shape == (2, 8)
    assert np.array_equal(states[:, :2], plain[:, :2])
    rocks = states[:, 2:].reshape(2, 2, 3)
    far, plain_far = (
        np.sqrt((one**2).sum(axis=2)) for one in (rocks, plain[:, 2:].reshape(2, 2, 3))
    )
    if changes == ("own frame",):
        np.testing.assert_allclose(far, plain_far)
    if "fading" in changes:
        assert ((far > 0.0) & (far <= 1.0)).all()
    if changes == ("ahead",):
        assert (rocks @ [1.0, 0.42, 0.46] > 0.0).all()
        assert (far >= plain_far - 1e-9).all()


@pytest.mark.parametrize("learner", ["knn, degrees", "svr, radians"])
def test_a_cell_is_tuned_fitted_and_flown(learner: str, monkeypatch: pytest.MonkeyPatch) -> None:
    known = reproduction.LEARNERS[learner]
    monkeypatch.setattr(reproduction, "LEARNERS", {learner: dict(list(known.items())[:2])})
    cell = Cell(learner=learner, pairs=300, flown_at=(1.0,))
    found = measured(cell, [5], fields=3, tuned_on=1)
    assert found.setting in known
    assert len(found.policies[1.0][0].outcomes) == 3


def test_a_cell_has_as_many_pairs_as_asked_for() -> None:
    states, actions = shown(Cell(pairs=50), seed=5)
    assert states.shape == (50, 8)
    assert actions.shape == (50, 2)


def test_every_row_of_the_report_has_its_cell() -> None:
    some = itself(Cell("straight", "itself", flown_at=DENSITIES), 2)
    cells = [*references(), *whole_map()]
    atlas = Atlas(dict.fromkeys(cells, Found("k 1", some.policies)))
    text = report(atlas, [1, 2], 2, "- here")
    assert text.count("two nearest") > 4
    assert "k 1" in text
