"""The recordings of people walking that a workspace keeps, to import from."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from evastudio.demonstrations.walks import read_walks
from evastudio.errors import InvalidInputError, StorageError, not_found
from evastudio.workspace import Workspace
from evastudio.writing import write_whole

FOLDER = "walks"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}\.(?:txt|csv)")


def walk_files(workspace: Workspace) -> list[Path]:
    """The files of recordings, in order of their names."""
    folder = workspace.root / FOLDER
    return sorted(path for path in folder.glob("*") if _NAME.fullmatch(path.name))


def walk_file(workspace: Workspace, name: str) -> Path:
    """A recording by the name of its file. Raises NotFoundError."""
    files = {path.name: path for path in walk_files(workspace)}
    if name not in files:
        raise not_found("recording", name, files)
    return files[name]


def keep_walks(workspace: Workspace, name: str, data: bytes, fps: float | None = None) -> Path:
    """Keep the bytes of a recording that can be read; one of that name is replaced.

    Raises InvalidInputError for a name that is none and for what is no recording.
    """
    if not _NAME.fullmatch(name):
        raise InvalidInputError(
            f"A recording cannot be called {name[:100]!r}: use 1 to 80 letters, digits, '_' and "
            "'-', and then .txt or .csv."
        )
    with tempfile.TemporaryDirectory() as folder:
        tried = Path(folder) / name
        tried.write_bytes(data)
        read_walks(tried, fps)
    return write_whole(workspace.root / FOLDER / name, data)


def forget_walks(workspace: Workspace, name: str) -> None:
    """Delete a recording; sessions made of it stay. Raises NotFoundError."""
    try:
        walk_file(workspace, name).unlink()
    except OSError as error:
        raise StorageError(f"{name!r} could not be deleted: {error.strerror}.") from None
