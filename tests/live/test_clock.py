"""A stage's time: slowed down it is still the world's own, and keys count in it."""

from __future__ import annotations

import pytest

from evastudio.live.clock import Clock


def test_slowed_down_steps_come_more_seldom_and_are_no_later() -> None:
    clock = Clock(0.1, 0.0)
    clock.start(0.0)
    clock.keep_pace(0.25, 0.0)
    assert clock.due == pytest.approx(0.4)
    done = sum(1 for tick in range(1, 4001) for _ in clock.due_steps(tick * 0.001))
    assert done == 10
    assert clock.late_steps == 0
    assert clock.interval == pytest.approx((1.0, 1.1))


def test_a_change_of_pace_in_the_middle_of_a_step_keeps_what_has_passed() -> None:
    clock = Clock(0.1, 0.0)
    clock.start(0.0)
    clock.keep_pace(0.5, 0.06)
    assert clock.world_time(0.06) == pytest.approx(0.06)
    assert clock.due == pytest.approx(0.06 + 0.08)
    assert clock.share(0.10) == pytest.approx(0.8)
    clock.keep_pace(1.0, 0.10)
    assert clock.due == pytest.approx(0.12)


def test_time_goes_on_while_nothing_is_decided() -> None:
    clock = Clock(0.1, 0.0)
    clock.start(0.0)
    assert list(clock.due_steps(0.1)) == [None]
    clock.start(5.0)
    assert clock.interval == pytest.approx((5.0, 5.1))
