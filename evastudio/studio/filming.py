"""Films: a run as one file to hand on, a page that plays it in 3D or a video."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.errors import InvalidInputError, not_found
from evastudio.learning.cleaning import Progress, silent
from evastudio.live.footage import Footage, policy_footage, take_footage
from evastudio.workspace import Workspace
from evastudio.writing import write_whole

SMALLEST, LARGEST = 64, 3840
"""Points a film is wide and high."""
_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,150}\.(html|mp4)")


class Form(StrEnum):
    PAGE = "html"
    """Plays in 3D in any browser, with no server and no network."""
    VIDEO = "mp4"


@dataclass(frozen=True)
class FilmFile:
    """A film that is kept."""

    name: str
    bytes: int
    created_at: float
    """Seconds since the epoch."""


def film(
    workspace: Workspace,
    footage: Footage,
    form: str = Form.PAGE,
    size: tuple[int, int] = (1280, 720),
    out: Path | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make `footage` into a file, `out` or one of the workspace's films: a job.

    `size` is a film's width and height. Raises ConflictError where PyAV is needed and not
    installed, InvalidInputError for a size that cannot be.
    """
    check(form, size)
    progress(0.0, "Setting the scene")
    reel = footage.reel(workspace)
    if form == Form.VIDEO:
        from evastudio.studio.video import video  # loads the compiler

        made = video(reel, footage.camera, size, progress=progress)
    else:
        from evastudio.studio.recorded import recorded

        made = recorded(reel, footage.camera, footage.title, progress=progress)
    path = write_whole(out or workspace.films / f"{footage.name}.{form}", made)
    seconds = (footage.moments - 1) * reel.scene.dt_s
    return {"film": path.name if out is None else str(path), "bytes": len(made), "seconds": seconds}


def check(form: str, size: tuple[int, int]) -> None:
    """Raise ConflictError or InvalidInputError where no such film can be made."""
    if form == Form.VIDEO:
        from evastudio.studio.video import ready

        ready()
    elif form != Form.PAGE:
        raise InvalidInputError(f"A film is made as 'html' or as 'mp4', not as {form!r}.")
    if not all(SMALLEST <= side <= LARGEST and side % 2 == 0 for side in size):
        raise InvalidInputError(
            f"A film of {size[0]} x {size[1]} cannot be made; both must be even, from {SMALLEST} "
            f"to {LARGEST}."
        )


def film_take(
    workspace: Workspace,
    take: int,
    *,
    form: str = Form.PAGE,
    size: tuple[int, int] = (1280, 720),
    camera: str | None = None,
    out: Path | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make a recorded take into a film: a job. Raises NotFoundError, ConflictError."""
    with Store(workspace.ready().store_url) as store:
        footage = take_footage(workspace, store, take, camera)
    return film(workspace, footage, form, size, out, progress)


def film_policy(
    workspace: Workspace,
    policy: str,
    *,
    seed: int = 0,
    scene: str | None = None,
    options: Mapping[str, float] | None = None,
    form: str = Form.PAGE,
    size: tuple[int, int] = (1280, 720),
    camera: str | None = None,
    out: Path | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Make what a policy does in the world of `seed` into a film. Raises NotFoundError."""
    footage = policy_footage(workspace, policy, seed, options, camera, scene)
    return film(workspace, footage, form, size, out, progress)


def films(workspace: Workspace) -> list[FilmFile]:
    """The films kept, by name."""
    found = []
    for path in sorted(workspace.films.glob("*")):
        if _NAME.fullmatch(path.name):
            told = path.stat()
            found.append(FilmFile(path.name, told.st_size, told.st_mtime))
    return found


def film_file(workspace: Workspace, name: str) -> Path:
    """Where the film of that name lies. Raises NotFoundError."""
    known = [one.name for one in films(workspace)]
    if name not in known:
        raise not_found("film", name, known)
    return workspace.films / name


def forget_film(workspace: Workspace, name: str) -> None:
    """Delete a film. Raises NotFoundError."""
    film_file(workspace, name).unlink(missing_ok=True)
