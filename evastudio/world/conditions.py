"""Conditions: what must be so of a character for a switch between policies, written or learned.

A condition is a few bounds on readings, all of which must hold. Readings are the signs of a scene,
the seconds since the world began, and every component of a perception's state, as
`perception.field`. Written as text:

| text                 | holds                                                                  |
|----------------------|------------------------------------------------------------------------|
| `event:impact`       | while the event of that name is so                                     |
| `after:30s`          | from 30 seconds after the beginning                                    |
| `region:0,0,5,2.5`   | while the character is there: x and y of two corners, metres           |
| `boulder<5`          | while a reading is below a number; `boulder>5` above it                |
| `A and B`            | while both do                                                          |
| `once A`             | from when A first held, for good                                       |
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import ConflictError, InvalidInputError, not_found
from evastudio.world.scene import Scene, Sign
from evastudio.world.snapshot import Snapshot
from evastudio.world.spaces import Array

SECONDS = Sign("seconds", "the time", "s")
"""Since the world began; a reading of every scene."""
MOST_BOUNDS = 16
_ONCE = "once "
_COMPARED = re.compile(r"([^<>\s]+)\s*([<>])\s*([^<>\s]+)")


@dataclass(frozen=True)
class Bound:
    """A reading lies from `low` to `high`."""

    reading: str
    """Name of a sign, `seconds`, or `perception.field`."""
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        if not self.low <= self.high or (np.isinf(self.low) and np.isinf(self.high)):
            raise InvalidInputError(
                f"The bounds of {self.reading!r} are {self.low} and {self.high}; give a number "
                "that it must be above, or below, or two in order."
            )

    def words(self, sign: Sign) -> str:
        """As a person reads it: 'the distance to the boulder is under 5 m'."""
        if sign.unit is None:
            return sign.label if self.low > 0.0 else f"it is not so that {sign.label}"
        unit = "" if sign.unit in ("", "1") else f" {sign.unit}"
        if np.isinf(self.high):
            said = f"over {self.low:.3g}{unit}"
        elif np.isinf(self.low):
            said = f"under {self.high:.3g}{unit}"
        else:
            said = f"from {self.low:.3g} to {self.high:.3g}{unit}"
        return f"{sign.label} is {said}"


@dataclass(frozen=True)
class Condition:
    """Every one of `bounds` holds, or, with `once`, all have held at one moment before."""

    bounds: tuple[Bound, ...]
    once: bool = False

    def __post_init__(self) -> None:
        if not 1 <= len(self.bounds) <= MOST_BOUNDS:
            raise InvalidInputError(
                f"A condition has {len(self.bounds)} bounds; it needs 1 to {MOST_BOUNDS}."
            )

    @property
    def readings(self) -> tuple[str, ...]:
        """Names of what it looks at."""
        return tuple(bound.reading for bound in self.bounds)

    def holds(self, readings: Mapping[str, Array]) -> NDArray[np.bool_]:
        """Where the bounds hold now, of the shape of each of `readings`."""
        parts = [
            (readings[bound.reading] >= bound.low) & (readings[bound.reading] <= bound.high)
            for bound in self.bounds
        ]
        return np.asarray(np.logical_and.reduce(parts))

    def check(self, scene: Scene) -> None:
        """Raise ConflictError for a reading that `scene` has not."""
        known = readable(scene)
        for name in self.readings:
            if name not in known:
                raise ConflictError(
                    f"The switch looks at {name!r}, which scene {scene.name!r} does not tell. "
                    f"{not_found('reading', name, known)}"
                )

    def words(self, scene: Scene) -> str:
        """As a person reads it: 'when the boulder has hit the ground'."""
        known = readable(scene)
        said = " and ".join(bound.words(known[bound.reading]) for bound in self.bounds)
        return f"{'once' if self.once else 'when'} {said}"

    def to_json(self) -> dict[str, Any]:
        bounds = [
            {
                "reading": bound.reading,
                "low": None if np.isinf(bound.low) else bound.low,
                "high": None if np.isinf(bound.high) else bound.high,
            }
            for bound in self.bounds
        ]
        return {"bounds": bounds, "once": self.once}

    @classmethod
    def from_json(cls, entry: Any) -> Condition:
        """What `to_json` gave. Raises InvalidInputError for anything else."""
        try:
            bounds = tuple(_bound(**one) for one in entry["bounds"])
            once = entry["once"]
        except (KeyError, TypeError) as error:
            raise InvalidInputError(f"a condition of it is not whole ({error})") from None
        if not isinstance(once, bool):
            raise InvalidInputError("it is not said whether a condition holds once and for all")
        return cls(bounds, once)


def _bound(reading: Any, low: Any, high: Any) -> Bound:
    numbers = [
        default if value is None else value for value, default in ((low, -np.inf), (high, np.inf))
    ]
    if not isinstance(reading, str) or not all(
        isinstance(number, int | float) and not isinstance(number, bool) for number in numbers
    ):
        raise InvalidInputError("a bound of a condition is not a name and two numbers")
    return Bound(reading, float(numbers[0]), float(numbers[1]))


def readable(scene: Scene) -> dict[str, Sign]:
    """Everything of `scene` that a condition can look at, by name."""
    fields = {
        f"{view.name}.{field.name}": Sign(
            f"{view.name}.{field.name}", f"{field.name.replace('_', ' ')} ({view.name})", field.unit
        )
        for view in scene.perceptions.values()
        for field in view.state.fields
    }
    return {SECONDS.name: SECONDS, **{sign.name: sign for sign in scene.signs}, **fields}


def read(
    scene: Scene, snapshot: Snapshot, seconds: Array, names: Iterable[str]
) -> dict[str, Array]:
    """The readings called `names`, each (worlds,), or (worlds, characters) where there are many.

    `seconds` (worlds,) have passed since each world began.
    """
    shape = (snapshot.worlds, *scene.characters)
    told: dict[str, Array] = {}
    states: dict[str, Array] = {}
    signs = [sign.name for sign in scene.signs]
    noticed: Array | None = None
    for name in names:
        if name == SECONDS.name:
            told[name] = np.broadcast_to(seconds.reshape(-1, *(1,) * len(scene.characters)), shape)
        elif name in signs:
            noticed = scene.notice(snapshot) if noticed is None else noticed
            told[name] = noticed[..., signs.index(name)]
        else:
            view = scene.perception(name.partition(".")[0])
            if view.name not in states:
                states[view.name] = view.perceive(snapshot).states
            told[name] = states[view.name][..., view.state.names.index(name.partition(".")[2])]
    return told


def parse_condition(text: str, scene: Scene) -> Condition:
    """The condition that `text` writes. Raises InvalidInputError, NotFoundError."""
    once = text.startswith(_ONCE)
    parts = text.removeprefix(_ONCE).split(" and ")
    bounds = tuple(bound for part in parts for bound in _parsed(part.strip(), text))
    known = readable(scene)
    for bound in bounds:
        if bound.reading not in known:
            raise not_found("sign", bound.reading, known, f"of scene {scene.name!r}")
    return Condition(bounds, once)


def _parsed(part: str, text: str) -> list[Bound]:
    kind, _, rest = part.partition(":")
    compared = _COMPARED.fullmatch(part)
    if kind == "event" and rest:
        return [Bound(rest, low=0.5)]
    if kind == "after" and rest:
        return [Bound(SECONDS.name, low=_number(rest.removesuffix("s"), text))]
    if kind == "region":
        numbers = [_number(one, text) for one in rest.split(",")]
        if len(numbers) == 4:
            (x0, x1), (y0, y1) = sorted(numbers[::2]), sorted(numbers[1::2])
            return [Bound("x", x0, x1), Bound("y", y0, y1)]
    if compared is not None:
        name, sign, number = compared.groups()
        value = _number(number, text)
        return [Bound(name, low=value) if sign == ">" else Bound(name, high=value)]
    raise InvalidInputError(
        f"The condition is {text!r}; write event:NAME, after:30s, region:x0,y0,x1,y1, NAME<5 or "
        "NAME>5, several joined by ' and ', and 'once ' before all that is to hold for good."
    )


def _number(word: str, text: str) -> float:
    try:
        number = float(word)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InvalidInputError(f"The condition {text!r} has {word!r} where a number is expected.")
    return number
