"""Learned switches: they fall where the marks are, whatever else could have been looked at."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.errors import InvalidInputError
from evastudio.learning.switching import MarkedTakes, learn_switch

STEPS = 60


def walks(rule, takes=10, seed=0, late=0):
    """Random walks of four readings, marked when `rule` of them begins or ceases to hold."""
    rng = np.random.default_rng(seed)
    readings, marks = [], []
    for _ in range(takes):
        event = np.arange(STEPS) >= rng.integers(5, 50)
        walk = 4.0 * rng.random((1, 2)) + np.cumsum(rng.uniform(-0.7, 0.7, (STEPS, 2)), axis=0)
        table = np.column_stack([event, walk, rng.normal(size=STEPS), np.arange(STEPS) / 2])
        holds = rule(table.T)
        begins = holds != np.concatenate([[False], holds[:-1]])
        if late:
            at = np.flatnonzero(begins)
            begins = np.zeros(STEPS, dtype=bool)
            begins[np.minimum(at + late, STEPS - 1)] = True
        readings.append(table)
        marks.append(begins)
    names = ("event", "x", "y", "noise", "seconds")
    return MarkedTakes(
        names, np.concatenate(readings), np.full(takes, STEPS), np.concatenate(marks)
    )


def once(holds):
    return np.maximum.accumulate(holds)


RULES = {
    "event": lambda r: r[0] > 0.5,
    "time": lambda r: r[4] >= 14.5,
    "side": lambda r: once(r[1] > 5.0),
    "while": lambda r: (r[1] > 1.0) & (r[1] < 3.5),
}


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("late", [0, 2])
def test_the_rule_behind_ten_marked_takes_is_kept_in_others(name, late) -> None:
    learned = learn_switch(walks(RULES[name], late=late))
    assert learned.delay_steps == (0 if name == "time" else late)
    unseen = walks(RULES[name], takes=100, seed=1, late=late if name == "time" else 0)
    holds = learned.condition.holds(dict(zip(unseen.names, unseen.readings.T, strict=True)))
    acting = unseen.acting(holds, learned.condition.once)
    assert unseen.near(acting).mean() >= 0.95
    assert learned.condition.once == (name != "while")
    assert "noise" not in learned.condition.readings


def test_what_tells_nothing_says_so() -> None:
    rng = np.random.default_rng(3)
    takes = walks(RULES["time"])
    marks = np.zeros((10, STEPS), dtype=bool)
    marks[np.arange(10), rng.integers(5, 55, 10)] = True
    blind = MarkedTakes(("noise",), takes.readings[:, 3:4], takes.lengths, marks.reshape(-1))
    learned = learn_switch(blind)
    assert learned.near < 5
    assert "does not tell your marks well" in learned.sentence(0.5)


def test_takes_without_a_mark_say_when_not_to_switch() -> None:
    takes = walks(lambda r: once((r[0] > 0.5) & (r[1] > 3.0)), takes=16)
    assert not np.add.reduceat(takes.marks, takes.starts).all()
    learned = learn_switch(takes)
    assert set(learned.condition.readings) == {"event", "x"}


def test_a_mark_in_one_take_is_enough_and_none_is_not() -> None:
    takes = walks(RULES["event"], takes=1)
    assert learn_switch(takes).condition.readings == ("event",)
    nothing = MarkedTakes(takes.names, takes.readings, takes.lengths, np.zeros(STEPS, dtype=bool))
    with pytest.raises(InvalidInputError, match="No moment is marked"):
        learn_switch(nothing)


def test_what_does_not_fit_together_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="must agree"):
        MarkedTakes(("x",), np.zeros((3, 2)), np.array([3]), np.zeros(3, dtype=bool))
