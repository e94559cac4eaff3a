"""Films: runs and takes as files to hand on, kept in the workspace."""

from __future__ import annotations

import contextlib
import re
import stat
from dataclasses import dataclass
from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import BinaryIO

from evastudio.errors import ConflictError, InvalidInputError, not_found
from evastudio.workspace import Workspace

SIZE = (1280, 720)
"""Width and height of a video, unless others are asked for."""
SMALLEST, LARGEST = 64, 3840
_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,200}\.(html|mp4)")


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


def check(form: str, size: tuple[int, int]) -> None:
    """Raise ConflictError where no video can be written, InvalidInputError where no such film can
    be."""
    if form not in set(Form):
        raise InvalidInputError(
            f"A film is made as {' or '.join(repr(str(one)) for one in Form)}, not as {form!r}."
        )
    if form == Form.VIDEO and find_spec("av") is None:
        raise ConflictError(
            "Videos are written by PyAV, which is not installed. Install it with: "
            "pip install 'evastudio[video]'. A page (.html) needs nothing."
        )
    if not all(SMALLEST <= side <= LARGEST and side % 2 == 0 for side in size):
        raise InvalidInputError(
            f"A film of {size[0]} x {size[1]} cannot be made; both must be even, from {SMALLEST} "
            f"to {LARGEST}."
        )


def films(workspace: Workspace) -> list[FilmFile]:
    """The films kept, by name."""
    found = []
    for path in sorted(workspace.films.glob("*")):
        with contextlib.suppress(FileNotFoundError):  # deleted meanwhile
            told = path.stat()
            if _NAME.fullmatch(path.name) and stat.S_ISREG(told.st_mode):
                found.append(FilmFile(path.name, told.st_size, told.st_mtime))
    return found


def open_film(workspace: Workspace, name: str) -> BinaryIO:
    """The film of that name, to be read, also where it is deleted meanwhile. Raises
    NotFoundError."""
    path = _path(workspace, name)
    try:
        return path.open("rb")
    except FileNotFoundError:  # deleted since it was looked for
        raise not_found("film", name, []) from None


def forget_film(workspace: Workspace, name: str) -> None:
    """Delete a film. Raises NotFoundError."""
    _path(workspace, name).unlink(missing_ok=True)


def _path(workspace: Workspace, name: str) -> Path:
    known = [one.name for one in films(workspace)]
    if name not in known:
        raise not_found("film", name, known)
    return workspace.films / name
