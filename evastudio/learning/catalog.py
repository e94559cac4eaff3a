"""The policies at hand: files in the user's folder and the shipped one."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evastudio.errors import InvalidInputError, StorageError, not_found
from evastudio.learning.policy_files import SUFFIX, read_policy_header
from evastudio.learning.switch import SUFFIX as SWITCH
from evastudio.learning.switch import Switch, load_switch

_NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,79}")


@dataclass(frozen=True)
class PolicyEntry:
    """One policy file."""

    name: str
    path: Path
    header: Mapping[str, Any] | None
    """What the file says of itself; None where it cannot be read."""
    problem: str | None
    """Why it cannot be read, or None."""
    switch: Switch | None = None
    """Where it is a switch between other policies."""


def list_policies(folders: Iterable[Path]) -> dict[str, PolicyEntry]:
    """Every policy and switch in `folders` by name, in order of the names.

    Where two share a name, the first folder's wins, and in one folder the policy.
    """
    entries: dict[str, PolicyEntry] = {}
    for folder in folders:
        for path in sorted(folder.glob("*" + SUFFIX)):
            header: Mapping[str, Any] | None = None
            problem = None
            try:
                header = read_policy_header(path)
            except StorageError as error:
                problem = str(error)
            name = path.name.removesuffix(SUFFIX)
            entries.setdefault(name, PolicyEntry(name, path, header, problem))
        for path in sorted(folder.glob("*" + SWITCH)):
            name = path.name.removesuffix(SWITCH)
            try:
                switch = load_switch(path)
                entry = PolicyEntry(name, path, switch.to_json(), None, switch)
            except StorageError as error:
                entry = PolicyEntry(name, path, None, str(error))
            entries.setdefault(name, entry)
    return dict(sorted(entries.items()))


def find_policy_file(reference: str, folders: Iterable[Path]) -> Path:
    """The file of a policy or switch given by its name or its path. Raises NotFoundError."""
    path = Path(reference)
    if path.name.endswith((SUFFIX, SWITCH)) and path.is_file():
        return path
    return policy_file_called(reference, folders)


def policy_file_called(name: str, folders: Iterable[Path]) -> Path:
    """The file of the policy or switch of that name in `folders`. Raises NotFoundError."""
    names = {
        path.name.removesuffix(suffix): path
        for folder in reversed(tuple(folders))
        for suffix in (SWITCH, SUFFIX)
        for path in folder.glob("*" + suffix)
    }
    if name not in names:
        raise not_found("policy", name, names)
    return names[name]


def checked_policy_name(name: str) -> str:
    """`name` if it can be a file's. Raises InvalidInputError."""
    if not _NAME.fullmatch(name):
        raise InvalidInputError(
            f"A policy cannot be called {name[:80]!r}: use 1 to 80 of a-z, 0-9, '.', '_' and '-', "
            "beginning with a letter or digit."
        )
    return name


def policy_name_from(text: str) -> str:
    """A policy name like `text`: 'My flight 2' gives 'my-flight-2'."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:80] or "policy"
