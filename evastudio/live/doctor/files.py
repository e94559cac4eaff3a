"""The files of a workspace: policies, switches, scenes and clips that cannot be used."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from evastudio.errors import StudioError
from evastudio.learning.catalog import list_policies
from evastudio.learning.policy_files import load_policy
from evastudio.live.clips import clips
from evastudio.live.doctor.finding import Finding, move_aside
from evastudio.live.headless import make_scene
from evastudio.live.piloting import cannot_play
from evastudio.motion.library import CHOICES
from evastudio.workspace import Workspace
from evastudio.world.loading import broken_scenes

ASIDE = "It is moved into the folder aside."


def look_at_files(workspace: Workspace, now: float) -> Iterator[Finding]:
    yield from _policies(workspace)
    yield from _scenes(workspace)
    yield from _clips(workspace)


def _policies(workspace: Workspace) -> Iterator[Finding]:
    known = list_policies(workspace.policy_folders)
    for entry in known.values():
        if entry.path.parent.resolve() != workspace.policies.resolve():
            continue
        about = f"policies/{entry.path.name}"
        problem = entry.problem
        if problem is None and entry.switch is None:
            try:
                load_policy(entry.path)
            except StudioError as error:
                problem = str(error)
        if problem is not None:
            yield Finding(about, problem, ASIDE, partial(move_aside, entry.path, workspace.root))
            continue
        made_for = (entry.header or {}).get("scene") or {}
        try:
            scene = make_scene(workspace, str(made_for.get("name")))
        except StudioError as error:
            yield Finding(about, f"Its scene is not here. {error}")
            continue
        if made_for.get("version") != scene.version:
            again = "Make it" if entry.switch is not None else "Fit it"
            yield Finding(
                about,
                f"It was made for version {made_for.get('version')} of the scene {scene.name!r}, "
                f"which is now version {scene.version}. {again} again.",
            )
        elif entry.switch is not None:
            missing = cannot_play(entry.switch, scene, known)
            if missing is not None:
                yield Finding(about, f"The switch cannot play. {missing}")


def _scenes(workspace: Workspace) -> Iterator[Finding]:
    folder = workspace.root / "scenes"
    for path, problem in broken_scenes([folder]).items():
        yield Finding(f"scenes/{path.name}", f"{problem} Takes of it wait until it works again.")


def _clips(workspace: Workspace) -> Iterator[Finding]:
    told = clips(workspace)
    if told["problem"]:
        path = workspace.motion / CHOICES
        yield Finding(
            f"motion/{CHOICES}", told["problem"], ASIDE, partial(move_aside, path, workspace.root)
        )
    for file in told["files"]:
        if file["problem"]:
            yield Finding(f"motion/{file['name']}", file["problem"])
    for activity in told["activities"]:
        if activity["problem"]:
            yield Finding(
                f"motion/{CHOICES}",
                f"The clip chosen for {activity['name']!r} cannot be played, so that the shipped "
                f"movement is. {activity['problem']}",
            )
