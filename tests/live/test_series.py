"""Takes follow one another after a rest, until as many are kept as are wanted."""

from __future__ import annotations

import pytest

from evastudio.errors import InvalidInputError
from evastudio.live.series import Arrangement, Series
from evastudio.live.status import Phase


def series(wanted: int | None = 3, rest_s: float = 2.0) -> tuple[Series, list[str]]:
    made, begun = Series(), list[str]()

    def again() -> None:
        begun.append("again")
        made.begun(again)

    made.arrange(Arrangement(wanted, True, rest_s))
    made.begun(again)
    return made, begun


def test_the_next_take_begins_after_the_rest() -> None:
    made, begun = series()
    made.beat(Phase.RECORDING, 0, 9.0)
    made.beat(Phase.ENDED, None, 10.0)
    assert made.told(11.5)["next_s"] == pytest.approx(0.5)
    made.beat(Phase.ENDED, 1, 11.9)
    assert not begun
    made.beat(Phase.ENDED, 1, 12.0)
    assert begun == ["again"]
    assert made.told(12.0)["next_s"] is None


def test_it_waits_until_the_takes_are_counted() -> None:
    made, begun = series(wanted=1)
    made.beat(Phase.ENDED, None, 10.0)
    made.beat(Phase.ENDED, None, 20.0)
    assert not begun
    made.beat(Phase.ENDED, 1, 20.1)
    assert not begun
    assert made.next_at is None


def test_enough_is_enough_until_a_person_begins_again() -> None:
    made, begun = series(wanted=2)
    made.beat(Phase.ENDED, 2, 10.0)
    made.beat(Phase.ENDED, 1, 10.1)  # one was thrown away meanwhile
    made.beat(Phase.ENDED, 1, 99.0)
    assert not begun


def test_a_take_thrown_away_is_followed_by_another() -> None:
    made, begun = series()
    made.beat(Phase.READY, 0, 10.0)
    made.beat(Phase.READY, 0, 12.0)
    assert begun == ["again"]


@pytest.mark.parametrize("phase", [Phase.PAUSED, Phase.REVIEWING, Phase.PLAYING, Phase.COUNTDOWN])
def test_nothing_begins_by_itself_while_something_else_goes_on(phase: Phase) -> None:
    made, begun = series()
    made.beat(Phase.ENDED, 1, 10.0)
    made.beat(phase, 1, 11.0)
    made.beat(Phase.ENDED, 1, 12.5)  # the rest begins anew
    made.beat(Phase.ENDED, 1, 14.0)
    assert not begun


def test_halted_or_switched_off_nothing_begins() -> None:
    made, begun = series()
    made.beat(Phase.ENDED, 1, 10.0)
    made.halt()
    made.beat(Phase.ENDED, 1, 20.0)
    made, later = series()
    made.beat(Phase.ENDED, 1, 10.0)
    made.arrange(Arrangement(3, False))
    made.beat(Phase.ENDED, 1, 20.0)
    assert begun == later == []


@pytest.mark.parametrize(
    "wrong", [(0, True, 1.0), (10_001, True, 1.0), (1, True, -1.0), (1, True, float("nan"))]
)
def test_an_arrangement_out_of_bounds_is_refused(wrong: tuple[int, bool, float]) -> None:
    with pytest.raises(InvalidInputError, match="must be"):
        Arrangement(*wrong)
