"""Whether the compiled kernels are at hand, without loading them or the compiler.

The first compilation takes some 25 s; from then on machine code is loaded from the user's cache
folder. Each state of the sources has a folder of its own there: numba looks at the one file a
function stands in, and would load old code where only a file it imports has changed. A mark in
the folder says that everything is compiled.
"""

from __future__ import annotations

import hashlib
import os
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
_seen: list[bool] = []
_loaded: list[bool] = []


def cache_folder() -> Path:
    """Where machine code is kept: NUMBA_CACHE_DIR, or a folder of the user's own."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        return Path(chosen)
    caches = os.environ.get("XDG_CACHE_HOME")
    return (Path(caches) if caches else Path.home() / ".cache") / "evastudio" / "numba"


def is_compiled() -> bool:
    """Whether loading the kernels is quick. It stays so while a process runs."""
    if not _seen and _mark().is_file():
        _seen.append(True)
    return bool(_seen)


def load() -> None:
    """Load the compiled code of worlds, if it is at hand, and use it for single worlds too.

    It takes half a second of CPU, which pays where worlds are lived through in real time.
    """
    if is_compiled() and not _loaded:
        import evastudio.world.kernels.rocks  # noqa: F401  # numba loads slowly

        _loaded.append(True)


def is_loaded() -> bool:
    """Whether `load` has ended in this process."""
    return bool(_loaded)


def note_compiled() -> None:
    """Leave the mark; `kernels.warm` does when it has run everything once."""
    mark = _mark()
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()


@cache
def code_folder() -> Path:
    """The folder for machine code made from these very sources, on such a processor."""
    digest = hashlib.sha256(f"{PACKAGE} {platform.processor()} {version('numba')}".encode())
    for source in sorted(PACKAGE.glob("*/kernels/*.py")):
        digest.update(source.read_bytes())
    return cache_folder() / digest.hexdigest()[:16]


def _mark() -> Path:
    return code_folder() / "compiled"
