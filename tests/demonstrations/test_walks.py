"""Recordings of people walking: read as they are, refused in a sentence where they cannot be."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evastudio.demonstrations import walks
from evastudio.demonstrations.walks import read_walks
from evastudio.errors import InvalidInputError, NotFoundError

HEAD = "# source=here.txt fps=25 columns: frame ped x_m y_m ; Us, CC0\n"


@pytest.fixture
def table(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        path = tmp_path / "walk.txt"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def row(frame: float, person: float, x: float, y: float = 0.0) -> str:
    return f"{frame} {person} {x} {y}\n"


def test_people_are_read_with_rate_source_and_credit(table: Callable[[str], Path]) -> None:
    rows = [row(100 + 10 * step, person, 0.5 * step) for step in range(8) for person in (1, 4)]
    found = read_walks(table(HEAD + "".join(rows)))
    assert (found.source, found.credit) == ("here.txt", "Us, CC0")
    assert len(found.people) == 2
    np.testing.assert_allclose(found.people[1].times_s, 0.4 * np.arange(8))
    np.testing.assert_allclose(found.people[1].places[:, 0], 0.5 * np.arange(8))


def test_commas_heights_and_rows_in_order_of_people_do_no_harm(
    table: Callable[[str], Path],
) -> None:
    rows = [f"{step},{person},{step},0,1.8\n" for person in (2, 1) for step in range(4)]
    found = read_walks(table("".join(rows)), fps=1.0)
    assert [len(one.times_s) for one in found.people] == [4, 4]
    assert found.source == ""


@pytest.mark.parametrize("dt_s", [0.25, 0.4, 0.5])
def test_a_steady_walk_is_as_steady_at_another_step(
    table: Callable[[str], Path], dt_s: float
) -> None:
    rows = [row(6 * step + 6, 1, 0.5 * step, -step) for step in range(20)]
    (walk,) = read_walks(table("".join(rows)), fps=16.0).people
    first, places = walk.every(dt_s)
    at = (first + np.arange(len(places))) * dt_s / 0.375
    np.testing.assert_allclose(places, np.column_stack([0.5 * at, -at]), atol=1e-9)
    assert len(places) == int(19 * 0.375 / dt_s) + 1


def test_who_is_not_seen_for_long_is_somebody_else(table: Callable[[str], Path]) -> None:
    rows = [row(frame, 1, frame) for frame in (0, 1, 2, 10, 11)]
    assert [len(one.times_s) for one in read_walks(table("".join(rows)), 1.0).people] == [3, 2]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no rows"),
        ("\x00\xff\x00 garbage", "expected four numbers"),
        (row(1, 1, 0) + "2 1 0.5\n", "Line 2 .* expected four numbers"),
        ("1 1 nan 0\n", "NaN"),
        ("1 1 0 inf\n", "infinity"),
        ("1 1 1e300 0\n", "beyond"),
        ("1.5 1 0 0\n", "whole numbers"),
        (row(1, 1, 0) + row(1, 1, 0.1), "repeat or go back"),
        (row(2, 1, 0) + row(1, 1, 0.1), "repeat or go back"),
        (row(1, 1, 0) + row(2, 1, 90), "nobody is faster"),
        (row(1, 1, 0) + row(1, 2, 9000), "Divide centimetres"),
        ("1 " * 200, "longer than"),
    ],
)
def test_a_bad_row_is_named(table: Callable[[str], Path], text: str, says: str) -> None:
    with pytest.raises(InvalidInputError, match=says):
        read_walks(table(text), fps=25.0)


@pytest.mark.parametrize("fps", ["0", "1e9", "...", "1.2.3"])
def test_a_rate_that_cannot_be_is_refused(table: Callable[[str], Path], fps: str) -> None:
    with pytest.raises(InvalidInputError, match="frames"):
        read_walks(table(f"# fps={fps}\n" + row(1, 1, 0)))


def test_without_a_rate_one_must_be_given(table: Callable[[str], Path]) -> None:
    with pytest.raises(InvalidInputError, match="--fps"):
        read_walks(table(row(1, 1, 0)))


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "nothing.txt"):
        with pytest.raises(NotFoundError, match="cannot be read"):
            read_walks(path)


def test_a_billion_frames_claimed_cost_nothing(table: Callable[[str], Path]) -> None:
    text = "".join(row(frame, 1, 0.1 * frame) for frame in range(4))
    far = "".join(row(10**11 + frame, 1, 0.1 * frame) for frame in range(4))
    first, second = read_walks(table(text + far), 1.0).people
    assert len(second.every(0.4)[1]) == len(first.every(0.4)[1])


def test_lines_that_say_nothing_hold_no_memory(table: Callable[[str], Path]) -> None:
    file = table("# fps=25\n" + "##\n" * 2_000_000)
    tracemalloc.start()
    try:
        with pytest.raises(InvalidInputError, match="holds no rows"):
            read_walks(file)
        assert tracemalloc.get_traced_memory()[1] < 1.2 * walks.MOST_BYTES
    finally:
        tracemalloc.stop()


def test_limits_are_told(table: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch) -> None:
    path = table("".join(row(1, person, 0) for person in range(30)))
    for name, limit, says in (
        ("MOST_PEOPLE", 20, "30 people"),
        ("MOST_ROWS", 10, "more than 10 rows"),
        ("MOST_BYTES", 50, "more than 50 bytes"),
    ):
        monkeypatch.setattr(walks, name, limit)
        with pytest.raises(InvalidInputError, match=says):
            read_walks(path, 25.0)
