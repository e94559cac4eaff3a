"""The scenes of a studio."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from evastudio.client.connection import Connection
from evastudio.client.reading import read


@dataclass(frozen=True)
class Field:
    """One component of a state or an action."""

    name: str
    unit: str
    low: float | None
    """None where there is no bound."""
    high: float | None


@dataclass(frozen=True)
class Perception:
    """A named way in which a character sees its world."""

    name: str
    summary: str
    state: tuple[Field, ...]


@dataclass(frozen=True)
class Option:
    """A number of a scene that its user chooses."""

    name: str
    default: float
    low: float
    high: float
    help: str


@dataclass(frozen=True)
class Scene:
    """A character and its world."""

    name: str
    title: str
    version: int
    dt_s: float
    """The decision step, seconds."""
    outcomes: tuple[str, ...]
    """What can become of a world; the first while it runs."""
    successes: tuple[str, ...]
    options: tuple[Option, ...]
    action: tuple[Field, ...]
    """In the world's frame; empty where it is one of a set of symbols."""
    symbols: tuple[str, ...]
    perceptions: tuple[Perception, ...]
    """The first is what is seen where none is named."""
    many: bool
    """Whether many characters share a world."""


class Scenes:
    """`studio.scenes`."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __iter__(self) -> Iterator[Scene]:
        """Every scene at hand."""
        return (_scene(told) for told in self._connection.pages("/scenes"))

    def get(self, name: str) -> Scene:
        """Raises NotFoundError."""
        return _scene(self._connection.get(f"/scenes/{name}"))


def _scene(told: Mapping[str, Any]) -> Scene:
    return read(
        Scene,
        told,
        outcomes=tuple(told["outcomes"]),
        successes=tuple(told["successes"]),
        symbols=tuple(told["symbols"]),
        options=tuple(read(Option, one) for one in told["options"]),
        action=_fields(told["action"]),
        perceptions=tuple(
            read(Perception, one, state=_fields(one["state"])) for one in told["perceptions"]
        ),
    )


def _fields(told: Any) -> tuple[Field, ...]:
    return tuple(read(Field, one) for one in told)
