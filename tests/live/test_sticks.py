"""Sticks pushed by mouse or gamepad become actions on the same path as keys, and feel as chosen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from evastudio.errors import InvalidInputError
from evastudio.live.inputs import Feel, HeldKeys
from evastudio.world.scene import Control
from evastudio.world.spaces import Box, Field, Symbols

DT = 1 / 15
RAMP = 0.3
ACTION = Box((Field("turn", "rad", -0.1, 0.1), Field("lift", "rad", -0.2, 0.4)))
CONTROLS = (
    Control("turn", "turn", ("KeyD",), ("KeyA",), RAMP),
    Control("lift", "lift", ("KeyS",), ("KeyW",), 0.0, reach=0.5),
)


def read(held: HeldKeys, steps: int, first: int = 0) -> np.ndarray:
    return np.concatenate([held.read(i * DT, (i + 1) * DT) for i in range(first, first + steps)])


def hands(feel: Feel | None = None) -> HeldKeys:
    return HeldKeys(CONTROLS, ACTION, DT, feel)


def test_a_stick_acts_at_once_and_as_far_as_it_is_pushed() -> None:
    held = hands()
    held.hold([], 0.0, {"turn": 0.6, "lift": -1.0})
    actions = read(held, 3)
    assert actions[:, 0] == pytest.approx(0.06)
    assert actions[:, 1] == pytest.approx(-0.2 * 0.5)


def test_a_stick_that_moves_within_a_step_counts_for_its_mean() -> None:
    held = hands()
    held.hold([], 0.0, {"turn": 1.0})
    held.hold([], 0.25 * DT, {"turn": 0.2})
    assert read(held, 1)[0, 0] == pytest.approx(0.1 * (0.25 * 1.0 + 0.75 * 0.2))


def test_a_flick_shorter_than_a_step_lasts_a_step() -> None:
    held = hands()
    held.hold([], 0.3 * DT, {"turn": 1.0})
    held.hold([], 0.5 * DT, {})
    assert read(held, 3)[:, 0] == pytest.approx([0.07, 0.03, 0.0])


def test_many_moves_of_a_stick_never_lag_behind() -> None:
    held = hands()
    for move in range(200):
        held.hold([], move / 60, {"turn": np.sin(move / 10)})
    actions = read(held, 50)[:, 0]
    assert actions[-1] == pytest.approx(0.1 * np.sin(19.75), abs=0.005)


def test_keys_and_a_stick_add_up_and_stay_within_bounds() -> None:
    held = hands(Feel(ramp=0.0))
    held.hold(["KeyA"], 0.0, {"turn": -0.25})
    assert read(held, 1)[0, 0] == pytest.approx(0.075)
    held.hold(["KeyA"], DT, {"turn": 1.0})
    assert read(held, 1, 1)[0, 0] == pytest.approx(0.1)


@pytest.mark.parametrize("sensitivity", [0.1, 0.5, 2.0])
def test_sensitivity_scales_keys_and_sticks_up_to_the_full_deflection(sensitivity: float) -> None:
    held = hands(Feel(sensitivity=sensitivity, ramp=0.0))
    held.hold(["KeyA"], 0.0, {"lift": 1.0})
    turn, lift = read(held, 1)[0]
    assert turn == pytest.approx(0.1 * min(sensitivity, 1.0))
    assert lift == pytest.approx(0.4 * min(0.5 * sensitivity, 1.0))


def test_the_ramp_is_stretched_for_keys_only() -> None:
    held = hands(Feel(ramp=2.0))
    held.hold(["KeyA"], 0.0)
    assert read(held, 9)[:, 0] == pytest.approx(0.1 * (np.arange(9) + 0.5) * DT / (2 * RAMP))
    held.hold([], 9 * DT, {"turn": 1.0})
    held.center()
    held.hold([], 9 * DT, {"turn": 1.0})
    assert read(held, 1, 9)[0, 0] == pytest.approx(0.1)


def test_another_feel_holds_from_now_on() -> None:
    held = hands()
    held.suit(Feel(sensitivity=0.5, ramp=0.0))
    held.hold(["KeyA"], 0.0)
    assert read(held, 1)[0, 0] == pytest.approx(0.05)


@pytest.mark.parametrize(
    "wrong", [{"sensitivity": 0.0}, {"sensitivity": 2.1}, {"ramp": -0.1}, {"ramp": float("nan")}]
)
def test_a_feel_out_of_bounds_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidInputError, match="must be from"):
        Feel(**wrong)


def test_a_stick_chooses_a_symbol_too() -> None:
    symbols = Symbols(("stand", "left", "right"))
    controls = (
        Control("left", "left", (), ("KeyA",), 0.0, latched=True),
        Control("right", "right", (), ("KeyD",), 0.0, latched=True),
    )
    held = HeldKeys(controls, symbols, 0.5)
    held.hold([], 0.0, {"right": 0.7})
    assert held.read(0.0, 0.5)[0, 0] == 2.0


@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 0.2),
            st.sets(st.sampled_from(["KeyA", "KeyD", "KeyW"])),
            st.dictionaries(st.sampled_from(["turn", "lift", "wings"]), st.floats(-9, 9)),
        ),
        max_size=20,
    ),
    st.floats(0.1, 2.0),
    st.floats(0.0, 3.0),
)
def test_whatever_is_pushed_the_action_stays_within_its_bounds(
    moves: list[tuple[float, set[str], dict[str, float]]], sensitivity: float, ramp: float
) -> None:
    held, now = hands(Feel(sensitivity, ramp)), 0.0
    for step, (wait, codes, pushed) in enumerate(moves):
        now += wait
        held.hold(codes, now, pushed)
        foreseen = held.foresee(step * DT, (step + 1) * DT)
        action = held.read(step * DT, (step + 1) * DT)
        assert np.array_equal(foreseen, action)
        assert (action >= ACTION.low - 1e-12).all()
        assert (action <= ACTION.high + 1e-12).all()
