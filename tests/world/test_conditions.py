"""Conditions: what is written is what holds, what is said, and what a file keeps."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.errors import ConflictError, InvalidInputError, NotFoundError
from evastudio.workspace import shipped
from evastudio.world.conditions import Bound, Condition, parse_condition, read
from evastudio.world.loading import load_scene_file

CROWD = load_scene_file(shipped() / "scenes" / "crowd.py")
WRITTEN = {
    "event:impact": "when the boulder has hit the ground",
    "impact<0.5": "when it is not so that the boulder has hit the ground",
    "after:30s": "when the time is over 30 s",
    "once region:0,5,7,2.5": "once the distance east is from 0 to 7 m and the distance north is "
    "from 2.5 to 5 m",
    "boulder<5 and event:impact": "when the distance to the boulder is under 5 m and the boulder "
    "has hit the ground",
    "paths.free_ahead>0.5": "when free ahead (paths) is over 0.5",
}


@pytest.mark.parametrize("text", WRITTEN)
def test_conditions_are_said_in_words_and_kept_in_json(text) -> None:
    scene = CROWD(people=3, side=9)
    condition = parse_condition(text, scene)
    condition.check(scene)
    assert condition.words(scene) == WRITTEN[text]
    assert Condition.from_json(condition.to_json()) == condition


def test_readings_are_of_everybody() -> None:
    scene = CROWD(people=3, side=9)
    snapshot = scene.worlds([1, 2])
    told = read(scene, snapshot, np.array([2.0, 3.0]), ["seconds", "x", "paths.free_ahead"])
    assert told["seconds"].tolist() == [[2.0] * 3, [3.0] * 3]
    assert told["x"] == pytest.approx(snapshot["position"][:, :, 0])
    free = scene.perception("paths").perceive(snapshot).states[:, :, 0]
    assert np.array_equal(told["paths.free_ahead"], free)
    region = parse_condition("region:1,0,3,9", scene)
    told = read(scene, snapshot, np.zeros(2), region.readings)
    x, y = np.moveaxis(snapshot["position"], 2, 0)
    assert np.array_equal(region.holds(told), (x >= 1) & (x <= 3) & (y >= 0) & (y <= 9))


@pytest.mark.parametrize(
    ("text", "error", "says"),
    [
        ("event:impct", NotFoundError, "Did you mean 'impact'"),
        ("soon", InvalidInputError, "write event:NAME"),
        ("after:dawn", InvalidInputError, "where a number is expected"),
        ("after:nan", InvalidInputError, "where a number is expected"),
        ("region:1,2,3", InvalidInputError, "write event:NAME"),
        ("x<1 and", InvalidInputError, "write event:NAME"),
        ("once ", InvalidInputError, "write event:NAME"),
        (" and ".join(["x<1"] * 17), InvalidInputError, "needs 1 to 16"),
    ],
)
def test_what_means_nothing_is_refused_in_a_sentence(text, error, says) -> None:
    with pytest.raises(error, match=says):
        parse_condition(text, CROWD(people=3, side=9))


def test_bounds_need_a_number_in_order() -> None:
    for low, high in ((2.0, 1.0), (np.nan, 1.0), (-np.inf, np.inf)):
        with pytest.raises(InvalidInputError, match="in order"):
            Bound("x", low, high)
    with pytest.raises(ConflictError, match="does not tell"):
        Condition((Bound("sonar", 1.0),)).check(CROWD(people=3, side=9))
