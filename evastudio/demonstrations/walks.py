"""Recordings of people walking: where each was, frame by frame, read from a table of text.

A row is frame, person, x and y in metres (a height after them is ignored), as in the Pedestrian
Dynamics Data Archive. Lines that begin with # tell the rate (fps=25), the source (source=...) and,
after a semicolon, whom to credit.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np
from scipy.interpolate import CubicSpline

from evastudio.errors import InvalidInputError, NotFoundError
from evastudio.world.spaces import Array

MOST_BYTES = 64_000_000
MOST_ROWS = 2_000_000
MOST_PEOPLE = 20_000
LONGEST_LINE = 200
WIDEST_M = 500.0
"""People farther apart than this are not in one scene."""
FASTEST = 12.0
"""Metres a second; nobody runs faster."""
LONGEST_GAP_S = 2.0
"""Somebody who is not seen for longer is somebody else when seen again."""
RATES_HZ = (0.5, 1000.0)


@dataclass(frozen=True)
class Walk:
    """One person, while seen without a long gap."""

    times_s: Array
    """Shape (rows,), rising, seconds since the recording's first frame."""
    places: Array
    """Shape (rows, 2), metres."""

    def every(self, dt_s: float) -> tuple[int, Array]:
        """The walk at whole multiples of `dt_s`: the first of them, and places (steps, 2).

        Between rows by a cubic spline, so that speeds do not jump. No places where it is too short.
        """
        first = int(np.ceil(self.times_s[0] / dt_s - 1e-6))
        last = int(np.floor(self.times_s[-1] / dt_s + 1e-6))
        at = np.clip(np.arange(first, last + 1) * dt_s, self.times_s[0], self.times_s[-1])
        if len(self.times_s) < 3 or len(at) == 0:
            return first, np.empty((0, 2))
        return first, np.asarray(CubicSpline(self.times_s, self.places)(at))


@dataclass(frozen=True)
class Walks:
    """Everybody in one recording."""

    name: str
    people: tuple[Walk, ...]
    source: str
    """What the recording says of where it is from; empty where it says nothing."""
    credit: str
    """Whom to credit, likewise."""


def read_walks(path: Path, fps: float | None = None) -> Walks:
    """The recording in the file at `path`; `fps` frames a second unless the file tells.

    Raises NotFoundError where there is no such file, InvalidInputError for one that is not as
    the module's docstring says, or that tells of what cannot be.
    """
    name = path.name
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise NotFoundError(f"{str(path)!r} cannot be read: {error.strerror}.") from None
    if len(data) > MOST_BYTES:
        raise InvalidInputError(
            f"{name!r} has more than {MOST_BYTES:,} bytes; a recording may have so many. Cut it "
            "into several."
        )
    told = [line for line in islice(_lines(data), 20) if line.lstrip().startswith("#")]
    rate = _rate(name, told, fps)
    frames, persons, places = _rows(name, _lines(data))
    if np.ptp(places, axis=0).max() > WIDEST_M:
        raise InvalidInputError(
            f"The people of {name!r} are up to {np.ptp(places, axis=0).max():g} m apart; expected "
            f"at most {WIDEST_M:g}, in metres. Divide centimetres by 100."
        )
    times_s = (frames - frames.min()) / rate
    people = tuple(_people(name, times_s, persons, places))
    return Walks(name, people, *_source(told))


def _rate(name: str, told: Sequence[str], fps: float | None) -> float:
    """Frames a second."""
    found = re.search(r"fps\s*=\s*([0-9.e+-]{1,12})", " ".join(told))
    given = fps
    if given is None:
        if found is None:
            raise InvalidInputError(
                f"{name!r} does not say how many frames there are in a second; give --fps, or let "
                "its first line be '# fps=25'."
            )
        try:
            given = float(found[1])
        except ValueError:
            given = float("nan")
    low, high = RATES_HZ
    if not low <= given <= high:
        raise InvalidInputError(
            f"{name!r} is taken to have {given:g} frames a second; expected {low:g} to {high:g}."
        )
    return given


def _source(told: Sequence[str]) -> tuple[str, str]:
    """The source and the credit that a recording's first lines give."""
    text = " ".join(line.strip().lstrip("#").strip() for line in told)
    found = re.search(r"source\s*=\s*(\S{1,80})", text)
    credit = text.rpartition(";")[2].strip() if ";" in text else ""
    source = "".join(letter for letter in (found[1] if found else "") if letter.isprintable())
    return source, "".join(letter for letter in credit[:80] if letter.isprintable())


def _lines(data: bytes) -> TextIO:
    """Line by line, so that memory holds no more than the rows."""
    return TextIOWrapper(BytesIO(data), encoding="utf-8", errors="replace")


def _rows(name: str, lines: Iterable[str]) -> tuple[Array, Array, Array]:
    """Frames (rows,), persons (rows,) and places (rows, 2) of all lines that hold numbers."""
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        where = f"Line {number} of {name!r}"
        if len(text) > LONGEST_LINE:
            raise InvalidInputError(f"{where} is longer than {LONGEST_LINE} letters; no row is.")
        parts = text.replace(",", " ").split()
        try:
            row = [float(part) for part in parts]
        except ValueError:
            row = []
        if len(row) not in (4, 5):
            raise InvalidInputError(
                f"{where} is {text[:60]!r}; expected four numbers: frame, person, x, y (m)."
            )
        if not all(map(np.isfinite, row[:4])) or max(map(abs, row[:4])) > 1e12:
            raise InvalidInputError(f"{where} holds NaN, infinity or a number beyond 1e12.")
        if row[0] != round(row[0]) or row[1] != round(row[1]):
            raise InvalidInputError(
                f"{where} is {text[:60]!r}; frame and person are whole numbers."
            )
        rows.append(row[:4])
        if len(rows) > MOST_ROWS:
            raise InvalidInputError(
                f"{name!r} has more than {MOST_ROWS:,} rows; keep every tenth frame."
            )
    if not rows:
        raise InvalidInputError(f"{name!r} holds no rows of frame, person, x and y.")
    table = np.array(rows)
    return table[:, 0], table[:, 1], table[:, 2:]


def _people(name: str, times_s: Array, persons: Array, places: Array) -> Iterator[Walk]:
    """One walk for each person, or several where there are long gaps; by person."""
    order = np.argsort(persons, kind="stable")
    known, starts = np.unique(persons[order], return_index=True)
    if len(known) > MOST_PEOPLE:
        raise InvalidInputError(
            f"{name!r} tells of {len(known):,} people; most are {MOST_PEOPLE:,}."
        )
    for person, rows in zip(known, np.split(order, starts[1:]), strict=True):
        passed_s = np.diff(times_s[rows])
        if (passed_s <= 0).any():
            raise InvalidInputError(
                f"The frames of person {person:g} in {name!r} repeat or go back; each must be "
                "later than the one before."
            )
        cuts = np.flatnonzero(passed_s > LONGEST_GAP_S) + 1
        for part in np.split(rows, cuts):
            speed = np.hypot(*np.diff(places[part], axis=0).T) / np.diff(times_s[part])
            if (speed > FASTEST).any():
                raise InvalidInputError(
                    f"Person {person:g} in {name!r} moves at {speed.max():g} m/s; nobody is "
                    f"faster than {FASTEST:g}. Check the unit, metres, and the frames a second."
                )
            yield Walk(times_s[part], places[part])
