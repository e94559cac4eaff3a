"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from evastudio.errors import StorageError

PART = ".part"
"""How files end that were being written when their writer was killed."""


def write_whole(path: Path, data: bytes) -> Path:
    """Write `data` to `path`, all of it or nothing, also where the power fails.

    Returns the path; raises StorageError.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=PART)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            Path(temporary).replace(path)
            _sync(path.parent)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise StorageError(
            f"{str(path)!r} could not be written: {error.strerror}. Choose a folder that "
            "exists, has room and may be written to."
        ) from None
    return path


def _sync(folder: Path) -> None:
    """Return when the names in `folder` are on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
