"""The clips of a workspace, and how they reach the scenes that people walk in."""

from __future__ import annotations

from typing import Any

from evastudio.errors import InvalidInputError, StorageError
from evastudio.motion.figures import figures
from evastudio.motion.library import ACTIVITIES, Choice, Library
from evastudio.motion.moment import Activity
from evastudio.motion.peopled import Peopled
from evastudio.workspace import Workspace
from evastudio.world.scene import Scene

LABELS = {
    "stand": "Stand",
    "walk": "Walk",
    "run": "Run",
    "stagger": "Stagger",
    "fallen": "Fall",
    "getting_up": "Get up",
}
"""What a person reads for each activity."""


def dress(scene: Scene, workspace: Workspace) -> None:
    """Let the people of `scene`, if it has any, move as was chosen in the workspace.

    A choice that cannot be played leaves the shipped movement; `clips` tells why.
    """
    if isinstance(scene, Peopled):
        try:
            scene.figures, _ = Library(workspace.motion).playable()
        except StorageError:
            scene.figures = figures()


def clips(workspace: Workspace) -> dict[str, Any]:
    """The workspace's files of clips, and what is chosen for each activity.

    Files and choices that cannot be used come with the reason.
    """
    library = Library(workspace.motion)
    problem: str | None = None
    choices: dict[Activity, Choice] = {}
    problems: dict[Activity, str] = {}
    try:
        choices, (_, problems) = library.choices(), library.playable()
    except StorageError as error:
        problem = str(error)
    activities = []
    for name, code in ACTIVITIES.items():
        choice = choices.get(code)
        activities.append(
            {
                "name": name,
                "label": LABELS[name],
                "file": None if choice is None else choice.file,
                "clip": None if choice is None else choice.clip,
                "problem": problems.get(code),
            }
        )
    return {
        "folder": str(library.folder.resolve()),
        "files": [
            {"name": file.name, "clips": list(file.clips), "problem": file.problem}
            for file in library.files()
        ],
        "activities": activities,
        "problem": problem,
    }


def choose_clip(
    workspace: Workspace, activity: str, file: str, clip: str | None = None
) -> dict[str, Any]:
    """Play a clip for an activity from now on; the only one of its file where none is named.

    Raises as `Library.choose`, and InvalidInputError where the file has several.
    """
    library = Library(workspace.motion)
    if clip is None:
        held = library.clips(file)
        if len(held) != 1:
            raise InvalidInputError(
                f"{file!r} has {len(held)} clips: {', '.join(held)}. Name the one that is meant."
            )
        (clip,) = held
    library.choose(activity, file, clip)
    return clips(workspace)


def forget_clip(workspace: Workspace, activity: str) -> dict[str, Any]:
    """Move as shipped in that activity; raises as `Library.forget`."""
    Library(workspace.motion).forget(activity)
    return clips(workspace)


def add_clips(workspace: Workspace, name: str, data: bytes) -> dict[str, Any]:
    """Keep a file of clips in the workspace; raises as `Library.add`."""
    Library(workspace.motion).add(name, data)
    return clips(workspace)
