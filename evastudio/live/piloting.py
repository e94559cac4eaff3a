"""Pilots by name: policies, switches between them, scripted demonstrators, and guards."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from evastudio.errors import InvalidInputError, NotFoundError, StudioError
from evastudio.learning import switch as switches
from evastudio.learning.catalog import (
    PolicyEntry,
    find_policy_file,
    list_policies,
    policy_file_called,
)
from evastudio.learning.policy_files import SUFFIX, load_policy
from evastudio.learning.switch import Switch, load_switch
from evastudio.pilots.guard import GUARDED, GuardedPilot
from evastudio.pilots.policy import PolicyPilot
from evastudio.pilots.scripted import find_pilot, is_program, pilot_names, suits
from evastudio.pilots.switchboard import Switchboard
from evastudio.workspace import Workspace
from evastudio.world.rollout import Pilot
from evastudio.world.scene import Scene


def file_named(reference: str) -> str | None:
    """What `reference` calls a file by: the name of a policy or switch; None for a program."""
    plain = reference.removeprefix(GUARDED)
    return None if is_program(plain) else plain


@dataclass(frozen=True)
class PilotEntry:
    """A pilot on offer."""

    name: str
    kind: Literal["own", "shipped", "program"]


def pilots_for(workspace: Workspace, scene: Scene) -> list[PilotEntry]:
    """Whoever can act in `scene`: the user's policies, those that come along, and programs."""
    known = list_policies(workspace.policy_folders)
    entries = []
    for name, entry in known.items():
        made_for = (entry.header or {}).get("scene")
        able = isinstance(made_for, dict) and (
            (made_for.get("name"), made_for.get("version")) == (scene.name, scene.version)
        )
        if not able or (entry.switch and cannot_play(entry.switch, scene, known)):
            continue
        mine = entry.path.parent.resolve() == workspace.policies.resolve()
        entries.append(PilotEntry(name, "own" if mine else "shipped"))
    entries.sort(key=lambda entry: (entry.kind != "own", entry.name))
    programs = [name for name in pilot_names() if suits(name, scene)]
    return [*entries, *(PilotEntry(name, "program") for name in programs)]


def load_pilot(workspace: Workspace, reference: str, scene: Scene) -> Pilot:
    """A pilot by name: a policy's or switch's name or file, one of `pilot_names`, or
    `guarded:` and any.

    Raises NotFoundError, StorageError for a damaged file, ConflictError for one of another scene.
    """
    plain = reference.removeprefix(GUARDED)
    pilot: Pilot
    if file_named(plain) is None:
        pilot = find_pilot(plain)
    else:
        path = _file(workspace, plain)
        if _is_switch(path):
            name = path.name.removesuffix(switches.SUFFIX)
            pilot = load_switchboard(workspace, load_switch(path), scene, name)
        else:
            pilot = PolicyPilot(load_policy(path), path.name.removesuffix(SUFFIX))
            pilot.check(scene)
    return pilot if plain == reference else GuardedPilot(pilot)


def load_switchboard(
    workspace: Workspace, switch: Switch, scene: Scene, name: str = "switch"
) -> Switchboard:
    """The pilot of a `switch`. Raises as `load_pilot`, naming the entry that cannot act."""
    pilots = []
    for number, entry in enumerate(switch.entries, start=1):
        try:
            plain = file_named(entry.policy)
            if plain is not None and _is_switch(_file(workspace, plain)):
                raise InvalidInputError(_nested(plain))
            pilots.append(load_pilot(workspace, entry.policy, scene))
        except StudioError as error:
            raise type(error)(f"Entry {number} of switch {name!r} cannot act. {error}") from None
    board = Switchboard(switch, pilots, name)
    board.check(scene)
    return board


def cannot_play(switch: Switch, scene: Scene, known: Mapping[str, PolicyEntry]) -> str | None:
    """Why `switch` cannot play in `scene` with the policies `known` at hand; None where it can."""
    try:
        for policy in switch.policies:
            name = file_named(policy)
            if name is None:
                find_pilot(policy.removeprefix(GUARDED))
            elif name not in known:
                return f"It needs the policy {name!r}, which is not here. Fit it under that name."
            elif known[name].switch is not None:
                return _nested(name)
        for entry in switch.entries:
            if entry.when is not None:
                entry.when.check(scene)
    except StudioError as error:
        return str(error)
    return None


def scene_of(workspace: Workspace, references: Iterable[str]) -> str:
    """The scene that the first of `references` that comes from a file was made for."""
    for name in references:
        plain = file_named(name)
        if plain is not None:
            path = _file(workspace, plain)
            if _is_switch(path):
                return str(load_switch(path).scene["name"])
            return load_policy(path).scene_name
    return "asteroids"


def fingerprint(workspace: Workspace, name: str) -> str | None:
    """SHA-256 of a policy's file, hexadecimal, of a switch with its policies' files; None for a
    pilot that is a program."""
    try:
        path = _file(workspace, name.removeprefix(GUARDED))
    except NotFoundError:
        return None
    digest = hashlib.sha256(path.read_bytes())
    if _is_switch(path):
        for policy in load_switch(path).policies:
            digest.update(str(fingerprint(workspace, policy)).encode())
    return digest.hexdigest()


def fitted_anew(workspace: Workspace, marks: Mapping[str, str | None]) -> list[str]:
    """Those of the policies in `marks`, fingerprints by name, whose files are others now."""
    return [name for name, mark in marks.items() if mark != fingerprint(workspace, name)]


def _nested(name: str) -> str:
    return f"{name!r} is itself a switch; list the policies that it is made of."


def _file(workspace: Workspace, reference: str) -> Path:
    """The file of a policy or switch by its name, or by its path where `workspace` allows that."""
    if workspace.paths:
        return find_policy_file(reference, workspace.policy_folders)
    return policy_file_called(reference, workspace.policy_folders)


def _is_switch(path: Path) -> bool:
    return path.name.endswith(switches.SUFFIX)
