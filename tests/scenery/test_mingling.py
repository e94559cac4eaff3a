"""What a walk through cells comes to."""

from __future__ import annotations

import numpy as np

from evastudio.scenery.mingling import (
    cells_a_minute,
    dithering,
    longest_still_s,
    longest_stuck_s,
)

YES, NO = True, False


def test_stuck_is_from_wanting_on_until_leaving_the_cell() -> None:
    places = np.array([[1], [1], [1], [1], [2], [2]])
    wants = np.array([[NO], [YES], [NO], [NO], [YES], [NO]])
    assert longest_stuck_s(places, wants, 0.5).tolist() == [1.0]
    assert longest_stuck_s(places, np.zeros_like(wants), 0.5).tolist() == [0.0]


def test_still_does_not_count_rests_that_were_chosen() -> None:
    places = np.array([[1, 1], [1, 1], [1, 1], [1, 1]])
    rests = np.array([[YES, NO], [YES, NO], [NO, NO], [YES, NO]])
    assert longest_still_s(places, rests, 0.5).tolist() == [0.5, 1.5]


def test_cells_are_counted_once_in_each_minute() -> None:
    back_and_forth = np.tile([3, 4], 60)
    onward = np.arange(120)
    places = np.stack([back_and_forth, onward], axis=1)
    assert cells_a_minute(np.concatenate([places, places]), 0.5).tolist() == [2.0, 120.0]
    assert np.isnan(cells_a_minute(places[:50], 0.5)).all()


def test_to_dither_is_to_take_a_turn_back_at_once() -> None:
    turns = np.array([[1, 1], [-1, 0], [1, -1], [0, -1], [0, 0]])
    assert dithering(turns).tolist() == [0.5, 0.0]
    assert np.isnan(dithering(turns[:1])).all()
