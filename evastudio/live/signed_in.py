"""Browsers that earlier runs of the studio let in: a restart does not send them away."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from evastudio.errors import StorageError
from evastudio.writing import write_whole

FILE = "signed-in.json"
"""In the workspace; without it nobody of an earlier run is let in."""
RUNS = 10
"""So many runs are remembered, the latest."""


def earlier_runs(folder: Path, digest: str) -> frozenset[str]:
    """The digests of the cookies that earlier runs gave; `digest`, this run's, is kept for later.

    Where the file cannot be read or written, nobody is remembered: the printed address lets in.
    """
    path = folder / FILE
    known: list[str] = []
    with contextlib.suppress(OSError, ValueError, TypeError):
        known = [one for one in json.loads(path.read_text()) if isinstance(one, str)]
    latest = [digest, *(one for one in known if one != digest)][:RUNS]
    with contextlib.suppress(StorageError):
        write_whole(path, json.dumps(latest).encode())
    return frozenset(latest[1:])
