"""Lineups: two to four runs of one world side by side, open in the studio until nobody looks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from evastudio.client.connection import Connection
from evastudio.client.reading import read


@dataclass(frozen=True)
class Happening:
    """Something to be seen in a run."""

    seconds: float
    kind: str
    """'sign', 'near' or 'outcome'."""
    says: str


@dataclass(frozen=True)
class Column:
    """One of the runs."""

    view: str
    """Path of its 3D view."""
    title: str
    """Who it is; of a ballot's only on which side it is."""
    length_s: float
    outcome: str | None
    """What became of it; None where it still went on when the longest that is shown was over."""
    success: bool | None
    parts_s: float | None
    """When it is no longer where the first column is; None where it is to the end."""
    happenings: Sequence[Happening]


@dataclass(frozen=True)
class Standing:
    """Where a lineup is, all of its columns at once."""

    position_s: float
    speed: float
    """How fast it goes on; 0 where it stands."""
    camera: str
    turned: bool
    """Whether a person turned the cameras from where the scene has them."""


@dataclass(frozen=True)
class Lineup:
    """Runs of one world, as they stood when they were told."""

    id: str
    scene: str
    dt_s: float
    length_s: float
    """Of the longest of them."""
    parts_s: float | None
    """The first moment at which they are not all in one place; None where there is none."""
    cameras: Sequence[str]
    columns: Sequence[Column]
    options: Mapping[str, float]
    world: int
    """Which of its series."""
    ballot: int | None
    """The one it is shown for."""
    standing: Standing


class Lineups:
    """`studio.lineups`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Lineup]:
        """One's own that are open, the first opened first."""
        return (lineup(told) for told in self._connection.pages("/lineups"))

    def get(self, name: str) -> Lineup:
        """One of one's own. Raises NotFoundError."""
        return lineup(self._connection.get(f"/lineups/{name}"))

    def open(
        self,
        scene: str,
        entrants: Sequence[str | int],
        *,
        options: Mapping[str, float] | None = None,
        seed: int = 0,
        world: int = 0,
    ) -> Lineup:
        """Fly two to four through one world: policies or other pilots by name, takes by number.

        It is the `world`-th of the series that an evaluation with that seed has, or a take's own.
        It closes itself once nobody has looked at it for a minute.
        """
        body = {
            "scene": scene,
            "options": dict(options or {}),
            "seed": seed,
            "world": world,
            "entrants": [{"take" if isinstance(one, int) else "pilot": one} for one in entrants],
        }
        return lineup(self._connection.post("/lineups", body))

    def standing(self, name: str) -> Standing:
        """Where it is now."""
        return read(Standing, self._connection.get(f"/lineups/{name}/standing"))

    def seek(self, name: str, seconds: float) -> Standing:
        """Stand at that moment."""
        return self._do(name, "seek", seconds=seconds)

    def roll(self, name: str, speed: float = 1.0) -> Standing:
        """Go on so fast: 0 stands, below 0 goes back."""
        return self._do(name, "roll", speed=speed)

    def look_through(self, name: str, camera: str | None = None) -> Standing:
        """Look through one of its cameras, or, as the scene has it, through the present one."""
        return self._do(name, "camera", camera=camera)

    def close(self, name: str) -> None:
        """Close one of one's own."""
        self._connection.delete(f"/lineups/{name}")

    def _do(self, name: str, command: str, **more: Any) -> Standing:
        told = self._connection.post(f"/lineups/{name}/commands", {"name": command, **more})
        return read(Standing, told)


def lineup(told: Mapping[str, Any]) -> Lineup:
    """The lineup that was told."""
    columns = [
        read(Column, one, happenings=[read(Happening, what) for what in one["happenings"]])
        for one in told["columns"]
    ]
    return read(Lineup, told, columns=columns, standing=read(Standing, told["standing"]))
