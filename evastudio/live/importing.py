"""Recordings of people walking into a session: one take for each of some who led."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.demonstrations.recorder import Recorder
from evastudio.demonstrations.retracing import (
    Stepped,
    at_step,
    elsewhere,
    record_retraced,
    retrace,
    trodden,
)
from evastudio.demonstrations.store import Store
from evastudio.demonstrations.walks import Walks, read_walks
from evastudio.errors import InvalidInputError
from evastudio.learning.cleaning import Progress, silent
from evastudio.live.headless import command_line, written
from evastudio.workspace import Workspace
from evastudio.world.loading import find_scene
from evastudio.world.scene import Scene

PEOPLE = 60
FOLDER = "EVASTUDIO_DATA"
"""Names the folder in which recordings are looked for that are not where they are said to be."""


def import_walks(
    workspace: Workspace,
    files: Sequence[str | Path],
    *,
    scene: str = "street",
    session: str | None = None,
    people: int = PEOPLE,
    fps: float | None = None,
    credit: str | None = None,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make takes of the people in recordings: their ways, among the others as they went.

    Of each file so many `people` lead a take, spread evenly over all who go somewhere. The session
    says where they are from, and `credit` is for files that do not. Raises NotFoundError and
    InvalidInputError for files and scenes that do not serve; then nothing is written.
    """
    if people < 1:
        raise InvalidInputError(f"{people} people were asked for; at least 1 must lead a take.")
    if not files:
        raise InvalidInputError("No recording was given; name at least one file.")
    kind = find_scene(scene, workspace.scene_folders)
    if kind.retraced is Scene.retraced:  # says that it cannot, before anything is written
        kind().retraced(np.empty((0, 0, 2)), np.empty((0, 2)), np.empty((0, 2)))
    progress(0.0, "Reading the recordings")
    recordings = [read_walks(_found(Path(file)), fps) for file in files]
    chosen = [_leads(walks, kind.dt_s, people) for walks in recordings]
    from_whom = credit or recordings[0].credit or recordings[0].name
    name = session or f"people of {recordings[0].name}"
    left = {"session": name, "people": people, "fps": fps, "credit": credit}
    command = command_line("import", *map(str, files), scene=scene, **left)
    done, total = 0, sum(len(leads) for _, leads in chosen)
    with Store(workspace.ready().store_url) as store:
        number = store.create_session(kind(), name, f"people: {from_whom}", clock(), command)
        recorder = Recorder(store, number, folders=workspace.unsaved)
        for walks, (stepped, leads) in zip(recordings, chosen, strict=True):
            said = ", ".join(part for part in (walks.source, credit or walks.credit) if part)
            ways = trodden(stepped)
            for lead in leads.tolist():
                begins = int(stepped.first[lead])
                ends = begins + len(stepped.places[lead])
                who = np.array([lead, *stepped.beside(lead, begins, ends)])
                retraced = retrace(kind, stepped, who, begins, ends, elsewhere(ways, lead))
                record_retraced(recorder, retraced, f"people: {said or walks.name}", clock())
                done += 1
                progress(done / total, f"{done} of {total} people")
        recorder.close(clock())
        return written(recorder, store)


def _leads(walks: Walks, dt_s: float, people: int) -> tuple[Stepped, NDArray[np.int64]]:
    """A recording at a scene's step, and who leads a take."""
    stepped = at_step(walks, dt_s)
    leads = stepped.travellers()
    if len(leads) == 0:
        raise InvalidInputError(
            f"Nobody in {walks.name!r} is seen to go anywhere; a recording of people who walk by "
            "is needed."
        )
    if people < len(leads):
        leads = leads[np.linspace(0, len(leads) - 1, people).round().astype(np.int64)]
    return stepped, leads


def _found(file: Path) -> Path:
    """The file, or that of its name in the folder of recordings."""
    folder = os.environ.get(FOLDER)
    if folder and not file.is_absolute() and not file.exists():
        return Path(folder) / file
    return file
