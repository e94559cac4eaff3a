"""Turns by hand are told from the echo of what was sent."""

from __future__ import annotations

import numpy as np

from evastudio.studio.turns import Turns
from evastudio.world.bodies import Camera

UP = np.array([0.0, 0.0, 1.0])


def behind(x: float, aside: float = 0.0) -> Camera:
    """A camera that follows somebody at `x`."""
    return Camera(np.array([x - 8.0, aside, 2.0]), np.array([x, 0.0, 0.0]), UP)


def test_what_was_sent_is_an_echo_however_late() -> None:
    turns = Turns()
    for x in range(60):
        turns.sent(behind(float(x)))
    assert all(turns.by_hand(1, behind(float(x))) is None for x in range(60))
    # Told between the message of the place and that of the aim.
    between = Camera(behind(31.0).position, behind(30.0).look_at, UP)
    assert turns.by_hand(1, between) is None


def test_a_turn_is_of_the_camera_that_looked_there_last() -> None:
    turns = Turns()
    for x in range(60):
        turns.sent(behind(float(x)))
    assert turns.by_hand(1, behind(57.0)) is None
    turned = behind(57.0, aside=3.0)
    before = turns.by_hand(1, turned)
    assert before is not None
    assert np.array_equal(before.position, behind(57.0).position)
    # What a person did is where the next turn begins.
    again = turns.by_hand(1, behind(57.0, aside=4.0))
    assert again is turned


def test_a_browser_that_has_not_drawn_yet_is_not_believed() -> None:
    turns = Turns()
    elsewhere = Camera(np.array([3.0, 3.0, 3.0]), np.zeros(3), UP)
    assert turns.by_hand(1, elsewhere) is None
    turns.sent(behind(0.0))
    assert turns.by_hand(1, elsewhere) is None
    assert turns.by_hand(1, behind(0.0)) is None
    assert turns.by_hand(1, elsewhere) is not None
    turns.left(1)
    assert turns.by_hand(1, behind(0.0, aside=9.0)) is None
