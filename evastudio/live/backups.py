"""Backups: one file that holds a workspace's store, as it is at one moment, and its files.

A zip of `backup.json`, which says what it is, `studio.db`, the store in SQLite whatever it was
kept in, and the folders of a workspace. So a store moves between databases, and anybody can look
inside. Pictures can be drawn again and are left out, and so are tokens and what waits to be saved.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from typing import Any

from evastudio.demonstrations.store import Store
from evastudio.demonstrations.transfer import copy_store, is_empty
from evastudio.errors import ConflictError, InvalidInputError, StorageError
from evastudio.learning.cleaning import Progress, silent
from evastudio.workspace import Workspace

FORMAT = 1
ABOUT, STORE = "backup.json", "studio.db"
FOLDERS = ("policies", "scenes", "motion")
"""Of a workspace, besides its store: switches lie among the policies, chosen clips in motion."""
ABOUT_BYTES = 1 << 16
COPIED = 0.8
"""The store's share of the work."""


def backup(
    workspace: Workspace,
    file: str | Path,
    *,
    clock: Callable[[], float] = time.time,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Write the workspace's store and files into the new file `file`, while others record.

    Raises ConflictError where that file is there already, StorageError where it cannot be written.
    """
    path = Path(file)
    if path.exists():
        raise ConflictError(f"The file {str(path)!r} is there already; choose another name.")
    files = dict(_files(workspace))
    with _told(path), tempfile.TemporaryDirectory(dir=path.parent, prefix=".backup-") as folder:
        copy, fresh = Path(folder) / STORE, Path(folder) / "backup.zip"
        with Store(workspace.ready().store_url) as store, Store(f"sqlite:///{copy}") as target:
            copied = copy_store(store, target, lambda share, _: progress(COPIED * share, "Copying"))
            pairs = target.pairs()
        about = {
            "evastudio_backup": FORMAT,
            "made_at": clock(),
            "sessions": copied["sessions"],
            "takes": copied["takes"],
            "pairs": pairs,
            "files": len(files),
        }
        with zipfile.ZipFile(fresh, "x", zipfile.ZIP_DEFLATED, compresslevel=1) as made:
            made.writestr(ABOUT, json.dumps(about, indent=2))
            made.write(copy, STORE)
            for name, one in files.items():
                progress(COPIED, name)
                made.write(one, name)
        with fresh.open("rb") as whole:
            os.fsync(whole.fileno())
        if path.exists():  # another was faster
            raise ConflictError(f"The file {str(path)!r} is there already; choose another name.")
        fresh.rename(path)
    progress(1.0, "Backed up")
    return _result(path, about)


def restore(
    workspace: Workspace, file: str | Path, *, progress: Progress = silent
) -> dict[str, Any]:
    """Put what a backup holds into a workspace whose store is empty or not there yet.

    Nothing that is there is written over. A restore that was cut off can be made again. Raises
    StorageError for what is no backup or damaged, ConflictError where something is in the way.
    """
    path = Path(file)
    root = workspace.ready().root
    with _told(path), zipfile.ZipFile(path) as opened:
        about, names = _checked(opened, path)
        progress(0.0, "Looking for damage")
        damaged = opened.testzip()
        if damaged is not None:
            raise zipfile.BadZipFile(f"{damaged!r} is not as it was written")
        _check_room(opened, root, names)
        with tempfile.TemporaryDirectory(dir=root, prefix=".restore-") as folder:
            copy = Path(opened.extract(STORE, folder))
            with Store(f"sqlite:///{copy}") as source, Store(workspace.store_url) as target:
                if not is_empty(target):
                    raise ConflictError(
                        "The workspace has sessions of its own, and a backup is not mixed with "
                        "them. Restore into a new folder with --workspace, or an empty database "
                        "with --store."
                    )
                for name in names:
                    _put(opened, name, root / name)
                copy_store(source, target, lambda share, _: progress(share, "Restoring"))
    return _result(path, about)


def _files(workspace: Workspace) -> Iterator[tuple[str, Path]]:
    """What a backup takes of a workspace's folders: the name within it, and the file."""
    for folder in FOLDERS:
        for path in sorted((workspace.root / folder).rglob("*")):
            inside = path.relative_to(workspace.root)
            hidden = any(part.startswith(".") or part == "__pycache__" for part in inside.parts)
            if path.is_file() and not hidden and path.suffix != ".part":
                yield inside.as_posix(), path


def _checked(opened: zipfile.ZipFile, path: Path) -> tuple[dict[str, Any], list[str]]:
    """What a backup says of itself, and its files. Raises StorageError where it is none."""
    names = opened.namelist()
    foreign = StorageError(
        f"{str(path)!r} is no backup of this studio; give a file that `evastudio backup` made."
    )
    if ABOUT not in names or STORE not in names or len(set(names)) != len(names):
        raise foreign
    if opened.getinfo(ABOUT).file_size > ABOUT_BYTES:
        raise foreign
    try:
        with opened.open(ABOUT) as told:
            about = json.loads(told.read(ABOUT_BYTES))
        version = about["evastudio_backup"]
    except (ValueError, KeyError, TypeError):
        raise foreign from None
    if version != FORMAT:
        raise StorageError(
            f"The backup {str(path)!r} has format {version!r}, this program reads {FORMAT}. Update "
            "evastudio to restore it."
        )
    files = [name for name in names if name not in (ABOUT, STORE)]
    for name in files:
        inside = PurePosixPath(name)
        if inside.is_absolute() or ".." in inside.parts or "\\" in name or "\x00" in name:
            raise foreign
        if len(inside.parts) < 2 or inside.parts[0] not in FOLDERS or name.endswith("/"):
            raise foreign
    return about, files


def _check_room(opened: zipfile.ZipFile, root: Path, names: list[str]) -> None:
    """Raise StorageError where a backup is too large, ConflictError where others are in the way.

    Files that are the same already are not in the way.
    """
    needed = sum(entry.file_size for entry in opened.infolist())
    free = shutil.disk_usage(root).free
    if needed > free:
        raise StorageError(
            f"The backup needs {needed / 1e6:,.0f} MB and {free / 1e6:,.0f} are free where the "
            "workspace is. Make room, or choose another folder with --workspace."
        )
    other = [name for name in names if (root / name).exists() and not _same(opened, name, root)]
    if other:
        more = f" and {len(other) - 3} more" if len(other) > 3 else ""
        raise ConflictError(
            f"The workspace has other files of the same names: {', '.join(other[:3])}{more}. "
            "Nothing was written; restore into a new folder with --workspace."
        )


def _same(opened: zipfile.ZipFile, name: str, root: Path) -> bool:
    path = root / name
    if not path.is_file() or path.stat().st_size != opened.getinfo(name).file_size:
        return False
    return zlib.crc32(path.read_bytes()) == opened.getinfo(name).CRC


def _put(opened: zipfile.ZipFile, name: str, path: Path) -> None:
    """Write one file of a backup, whole or not at all, unless the same is there."""
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as part:
        try:
            with opened.open(name) as packed:
                shutil.copyfileobj(packed, part)
            part.flush()
            Path(part.name).rename(path)
        except BaseException:
            Path(part.name).unlink(missing_ok=True)
            raise


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """What goes wrong with the file, as sentences."""
    try:
        yield
    except FileNotFoundError:
        raise InvalidInputError(
            f"There is no file {str(path)!r}, or no folder for it; check its name."
        ) from None
    except OSError as error:
        raise StorageError(
            f"The backup {str(path)!r} cannot be read or written: {error.strerror}. Choose a "
            "folder that exists, has room and may be written to."
        ) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise StorageError(
            f"{str(path)!r} is no backup, or damaged ({error}); take another."
        ) from None


def _result(path: Path, about: dict[str, Any]) -> dict[str, Any]:
    made = datetime.fromtimestamp(float(about["made_at"]), UTC).isoformat(timespec="seconds")
    counts = {name: about[name] for name in ("sessions", "takes", "pairs", "files")}
    return {"backup": str(path), "made": made, **counts, "bytes": path.stat().st_size}
