"""Held keys become actions as the ramp says, to the moment."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from evastudio.live.inputs import HeldKeys
from evastudio.world.scene import Control
from evastudio.world.spaces import Box, Field

DT = 1 / 15
RAMP = 0.3
ACTION = Box((Field("turn", "rad", -0.1, 0.1), Field("lift", "rad", -0.2, 0.4)))
CONTROLS = (
    Control("turn", "turn", ("KeyD",), ("KeyA", "ArrowLeft"), RAMP),
    Control("lift", "lift", ("KeyS",), ("KeyW",), 0.0),
)


def keys() -> HeldKeys:
    return HeldKeys(CONTROLS, ACTION, DT)


def read(held: HeldKeys, steps: int, first: int = 0) -> np.ndarray:
    return np.concatenate([held.read(i * DT, (i + 1) * DT) for i in range(first, first + steps)])


def test_nothing_held_is_no_action() -> None:
    assert np.array_equal(read(keys(), 5), np.zeros((5, 2)))


def test_a_held_key_ramps_up_to_the_limit_and_back() -> None:
    held = keys()
    held.hold(["KeyA"], 0.0)
    up = read(held, 10)[:, 0]
    ramp = np.minimum((np.arange(10) + 0.5) * DT / RAMP, 1.0)
    assert up[:4] == pytest.approx(0.1 * ramp[:4])
    assert up[5:] == pytest.approx(0.1)
    held.hold([], 10 * DT)
    down = read(held, 10, 10)[:, 0]
    assert down[:4] == pytest.approx(0.1 - 0.1 * ramp[:4])
    assert down[5:] == pytest.approx(0.0, abs=1e-12)


def test_without_a_ramp_a_key_acts_at_once_with_its_own_bound() -> None:
    held = keys()
    held.hold(["KeyW"], 0.0)
    assert read(held, 2)[:, 1] == pytest.approx(0.4)
    held.hold(["KeyS"], 2 * DT)
    assert read(held, 2, 2)[:, 1] == pytest.approx(-0.2)


def test_two_keys_of_one_way_are_one_and_opposite_ones_cancel() -> None:
    held = keys()
    held.hold(["KeyA", "ArrowLeft"], 0.0)
    assert read(held, 10)[-1, 0] == pytest.approx(0.1)
    held.hold(["KeyA", "KeyD"], 10 * DT)
    assert read(held, 10, 10)[-1, 0] == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0.0, 0.99), st.floats(0.0001, 0.9))
def test_a_tap_shorter_than_a_step_still_counts(start: float, length: float) -> None:
    held = keys()
    held.hold(["KeyA"], start * DT)
    held.hold([], (start + length) * DT)
    actions = read(held, 12)[:, 0]
    full = keys()
    full.hold(["KeyA"], start * DT)
    full.hold([], (start + 1.0) * DT)
    assert actions.sum() == pytest.approx(read(full, 12)[:, 0].sum(), rel=1e-6)
    assert actions.sum() > 0.01


def test_a_tap_that_arrives_late_counts_too() -> None:
    held = keys()
    read(held, 3)
    held.hold(["KeyA"], 1.2 * DT)
    held.hold([], 1.3 * DT)
    assert read(held, 10, 3)[:, 0].sum() > 0.01


@given(
    st.lists(
        st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 3.0), st.sampled_from([0.0, 0.0, 5.3])),
        min_size=1,
        max_size=20,
    )
)
def test_however_presses_fall_between_readings_each_counts_for_a_step(
    edges: list[tuple[float, float, float]],
) -> None:
    """Each edge comes so many steps after the one before, so many later still it arrives, and the
    clock stood still so long before the next reading."""
    held, at, arrived, now = keys(), 0.0, 0.0, 0.0
    total, presses = 0.0, 0
    edges = [*edges, *edges]
    for number, (gap, delay, stand) in enumerate(edges):
        at += gap
        arrived = max(arrived, at + delay)
        while now + 1.0 <= arrived:
            total += held.read(now * DT, (now + 1.0) * DT)[0, 1]
            now += 1.0
        presses += number % 2 == 0
        held.hold(["KeyW"] if number % 2 == 0 else [], at * DT)
        now += stand
        at += stand
    for step in range(len(edges) + 1):
        total += held.read((now + step) * DT, (now + step + 1.0) * DT)[0, 1]
    assert total / 0.4 > presses - 1e-9
    now += len(edges) + 1
    assert held.read(now * DT, (now + 1.0) * DT)[0, 1] == 0.0


@given(st.lists(st.tuples(st.floats(0.0, 4.0), st.sets(st.sampled_from(["KeyA", "KeyD", "KeyW"])))))
def test_what_is_foreseen_is_what_is_read_and_takes_nothing_away(
    presses: list[tuple[float, set[str]]],
) -> None:
    held = keys()
    for at, codes in sorted(presses, key=lambda press: press[0]):
        held.hold(codes, at * DT)
    for step in range(6):
        foreseen = held.foresee(step * DT, (step + 1) * DT)
        assert np.array_equal(held.foresee(step * DT, (step + 1) * DT), foreseen)
        assert np.array_equal(held.read(step * DT, (step + 1) * DT), foreseen)


def test_centering_forgets_everything() -> None:
    held = keys()
    held.hold(["KeyA", "KeyW"], 0.0)
    read(held, 10)
    held.hold(["KeyD"], 20 * DT)
    held.center()
    assert np.array_equal(read(held, 5, 10), np.zeros((5, 2)))
    assert held.held == frozenset()


@given(
    st.lists(
        st.tuples(st.floats(0.0, 0.2), st.sets(st.sampled_from(["KeyA", "KeyD", "KeyW", "Esc"]))),
        max_size=30,
    )
)
def test_whatever_is_pressed_the_action_stays_within_its_bounds(
    edges: list[tuple[float, set[str]]],
) -> None:
    held, now = keys(), 0.0
    for step, (wait, codes) in enumerate(edges):
        now += wait
        held.hold(codes, now)
        action = held.read(step * DT, (step + 1) * DT)
        assert np.isfinite(action).all()
        assert (action >= ACTION.low - 1e-12).all()
        assert (action <= ACTION.high + 1e-12).all()


def latched(*edges: tuple[float, str]) -> list[float]:
    """What three decisions half a second apart take from a key pressed and released."""
    control = Control("turn", "turn", (), ("KeyA",), 0.0, latched=True)
    keys = HeldKeys((control,), Box((Field("turn", "1", -1.0, 1.0),)), 0.5)
    for at, code in edges:
        keys.hold([code] if code else [], at)
    return [float(keys.read(end - 0.5, end)[0, 0]) for end in (0.5, 1.0, 1.5)]


def test_of_a_latched_control_the_key_held_at_the_decision_counts() -> None:
    assert latched((0.45, "KeyA"), (1.2, "")) == [1.0, 1.0, 0.0]
    assert latched((0.0, "KeyA"), (0.95, "")) == [1.0, 0.0, 0.0]


def test_a_tap_between_latched_decisions_counts_once() -> None:
    assert latched((0.1, "KeyA"), (0.15, "")) == [1.0, 0.0, 0.0]
    assert latched((0.6, "KeyA"), (0.9, "")) == [0.0, 1.0, 0.0]
