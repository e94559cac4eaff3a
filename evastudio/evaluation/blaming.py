"""Faults in a scene, which is a user's file, told as a sentence that says where they are."""

from __future__ import annotations

import contextlib
import inspect
import traceback
from collections.abc import Iterator
from pathlib import Path

from evastudio.errors import InvalidInputError, StudioError
from evastudio.workspace import shipped
from evastudio.world.scene import Scene


@contextlib.contextmanager
def blaming(scene: Scene, pilot: str) -> Iterator[None]:
    """Whatever fails within becomes an InvalidInputError that says what failed, and where.

    A scene is a user's file and may raise anything, or give what cannot be worked with. What fails
    outside of a shipped scene stays as it is: the fault is ours.
    """
    try:
        yield
    except StudioError:
        raise
    except Exception as error:
        file = inspect.getfile(type(scene))
        frames = traceback.extract_tb(error.__traceback__)
        inside = [at for at in frames if at.filename == file]
        if not inside and Path(file).parent == shipped() / "scenes":
            raise
        at = (inside or frames)[-1]
        raise InvalidInputError(
            f"Scene {scene.name!r} failed while {pilot!r} acted in it: {type(error).__name__}: "
            f"{error} ({at.filename}, line {at.lineno}). `evastudio check` tries a scene's file."
        ) from error
