"""A switch: which policies take turns, and when; and the file that keeps it.

The file is JSON, `name.switch.json`, beside the policies it names. It holds no numbers of theirs.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evastudio.errors import InvalidInputError, StorageError
from evastudio.world.conditions import Condition
from evastudio.world.scene import Scene
from evastudio.writing import write_whole

FORMAT = 1
SUFFIX = ".switch.json"
MAX_BYTES = 1_000_000
MOST_ENTRIES = 16


@dataclass(frozen=True)
class Entry:
    """A policy, and when it acts."""

    policy: str
    """Its name."""
    when: Condition | None
    """None in the last entry alone: it acts where no other does."""
    learned: Mapping[str, Any] | None = None
    """How its condition was learned from marks; None where it was written."""


@dataclass(frozen=True)
class Switch:
    """At every decision the first of `entries` whose condition holds acts."""

    entries: tuple[Entry, ...]
    scene: Mapping[str, Any]
    """Name and version of the scene."""
    made_by: str = ""
    """The command that makes it again."""
    created: str = ""
    """When, ISO 8601; given by whoever made it."""

    def __post_init__(self) -> None:
        if not 2 <= len(self.entries) <= MOST_ENTRIES:
            raise InvalidInputError(
                f"A switch has {len(self.entries)} policies; it needs 2 to {MOST_ENTRIES}."
            )
        if [entry.when is None for entry in self.entries] != [False] * (len(self.entries) - 1) + [
            True
        ]:
            raise InvalidInputError(
                "Every policy of a switch but the last needs a condition, and the last has none: "
                "it acts where no other does."
            )

    @property
    def policies(self) -> tuple[str, ...]:
        return tuple(entry.policy for entry in self.entries)

    def words(self, scene: Scene) -> str:
        """As a person reads it: 'crowd-hurried; when the boulder has hit, crowd-fleeing.'"""
        *before, last = self.entries
        parts = [
            f"{entry.when.words(scene)}, {entry.policy}"
            for entry in reversed(before)
            if entry.when is not None
        ]
        return "; ".join([last.policy, *parts]) + "."

    def to_json(self) -> dict[str, Any]:
        return {
            "format": FORMAT,
            "scene": dict(self.scene),
            "entries": [
                {
                    "policy": entry.policy,
                    "when": None if entry.when is None else entry.when.to_json(),
                    "learned": None if entry.learned is None else dict(entry.learned),
                }
                for entry in self.entries
            ],
            "made_by": self.made_by,
            "created": self.created,
        }


def save_switch(switch: Switch, path: str | Path) -> Path:
    """Write `switch` to `path`, all of it or nothing. Raises StorageError."""
    text = json.dumps(switch.to_json(), indent=1, allow_nan=False) + "\n"
    return write_whole(Path(path), text.encode())


def load_switch(path: str | Path) -> Switch:
    """The switch in `path`. Raises StorageError, saying what is wrong, for anything else."""
    path = Path(path)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise StorageError(
            f"The switch {path} could not be read: {error.strerror}. Check the name; switches end "
            f"in {SUFFIX}."
        ) from None
    return parse_switch(data, str(path))


def parse_switch(data: bytes, what: str) -> Switch:
    """The switch that the bytes of a file are. Raises StorageError, calling the file `what`."""
    try:
        if len(data) > MAX_BYTES:
            raise InvalidInputError(f"it is larger than {MAX_BYTES // 1_000_000} MB")
        told = json.loads(data.decode("utf-8"))
        json.dumps(told, ensure_ascii=False, allow_nan=False).encode()  # what a page cannot be told
        return _switch(told)
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        reason = (
            str(error).rstrip(".") if isinstance(error, InvalidInputError) else "it is not whole"
        )
        raise StorageError(
            f"{what} is not a switch that can be used: {reason}. It may be damaged, cut short or "
            "made by another program; make the switch again or take a fresh copy."
        ) from None


def _switch(header: Any) -> Switch:
    if header["format"] != FORMAT:
        raise InvalidInputError(
            f"its format is {header['format']!r}, and this studio reads {FORMAT}"
        )
    scene, entries = header["scene"], header["entries"]
    if not isinstance(scene["name"], str) or type(scene["version"]) is not int:
        raise InvalidInputError("the scene it names has no name or version")
    if not isinstance(entries, list):
        raise InvalidInputError("its policies are not listed")
    for name in ("made_by", "created"):
        if not isinstance(header[name], str):
            raise InvalidInputError(f"its entry {name!r} is not text")
    return Switch(
        tuple(_entry(one) for one in entries), scene, header["made_by"], header["created"]
    )


def _entry(entry: Any) -> Entry:
    policy, when, learned = entry["policy"], entry["when"], entry["learned"]
    if not isinstance(policy, str) or not isinstance(learned, dict | None):
        raise InvalidInputError("an entry of it names no policy")
    return Entry(policy, None if when is None else Condition.from_json(when), learned)
