"""The folder of a workspace: can it be written, is there room, what was left half-written."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from evastudio.live.doctor.finding import Finding, move_aside
from evastudio.workspace import Workspace
from evastudio.writing import PART

FREE_BYTES = 500_000_000
"""With less the disk counts as nearly full: an hour of takes and a few policies have room."""
OLD_S = 60.0
"""A younger file may still be being written."""


def look_at_folder(workspace: Workspace, now: float) -> Iterator[Finding]:
    root = workspace.root
    if not root.is_dir():
        yield Finding(str(root), "There is no such folder; name a workspace with --workspace.")
        return
    for folder in (root, workspace.policies, root / "scenes", workspace.motion):
        if folder.exists() and not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
            yield Finding(
                str(folder), "The folder cannot be read or written; change its permissions."
            )
    file = root / "studio.db"
    if file.exists() and not os.access(file, os.R_OK | os.W_OK):
        yield Finding(str(file), "The store cannot be read or written; change its permissions.")
    free = shutil.disk_usage(root).free
    if free < FREE_BYTES:
        yield Finding(
            str(root),
            f"The disk is nearly full: {free / 1e6:.0f} MB are free. Make room; what cannot be "
            "saved waits elsewhere meanwhile.",
        )
    for path in _half_written(workspace):
        if now - path.stat().st_mtime > OLD_S:
            yield Finding(
                str(path.relative_to(root)),
                "The file was being written when its writer was ended; nobody reads it.",
                "It is moved into the folder aside.",
                partial(move_aside, path, root),
            )


def _half_written(workspace: Workspace) -> list[Path]:
    folders = (workspace.policies, workspace.motion, workspace.pictures)
    return sorted(path for folder in folders for path in folder.rglob("*" + PART))
