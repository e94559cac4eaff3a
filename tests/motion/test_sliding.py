"""Feet stay where they stand: every shipped walk, under 3 cm a step."""

from __future__ import annotations

import numpy as np
import pytest

from evastudio.motion.figures import SPEEDS, Figures
from evastudio.motion.sliding import sliding_cm

FIGURES = Figures()


@pytest.mark.parametrize("manner", [-1.0, -0.4, 0.0, 0.7, 1.0])
def test_no_shipped_gait_slides_3_cm_a_step(manner: float) -> None:
    for speed in (0.25, *SPEEDS[1:], 0.9, 1.4, 2.0, 2.2, 3.2):
        for turn_rate in (0.0, 0.8, -0.8):
            slid = sliding_cm(FIGURES, speed, turn_rate, manner)
            assert slid.max() < 3.0, (speed, turn_rate, slid)


@pytest.mark.parametrize("turn_rate", [-2.0, -0.8, 0.5, 1.5])
def test_turning_on_the_spot_steps_instead_of_sliding(turn_rate: float) -> None:
    assert sliding_cm(FIGURES, 0.0, turn_rate).max() < 3.0


@pytest.mark.parametrize("size", [0.75, 1.2])
def test_small_and_tall_people_do_not_slide_either(size: float) -> None:
    assert sliding_cm(FIGURES, 1.3, size=size).max() < 3.0


def test_a_phase_that_does_not_follow_the_ground_would_be_found() -> None:
    class Skating(Figures):
        def cadence(self, *args: float, **named: float) -> np.ndarray:  # type: ignore[override]
            return np.asarray(super().cadence(*args, **named))

        def joints(self, moment):  # type: ignore[no-untyped-def]
            return super().joints(type(moment)(**{**vars(moment), "phases": moment.phases * 0.8}))

    assert sliding_cm(Skating(), 1.3).max() > 3.0
