"""A section of docs/reliability.md."""

from __future__ import annotations

import time
from collections.abc import Sequence

from benchmarks.report import ROOT, commit, where_and_when, write_section


class Section:
    """Begun before anything is measured: it tells how long that took, and of which commit."""

    def __init__(self, name: str, *paths: str) -> None:
        self.name = name
        self._at = commit("evastudio", *paths, "benchmarks/soak")
        self._begun = time.monotonic()

    def write(self, lines: Sequence[str], quick: bool) -> None:
        """Print `lines`, and put them into the document unless `quick`."""
        command = f"python -m benchmarks.soak --only {self.name}"
        where = where_and_when(self._at, command, time.monotonic() - self._begun)
        text = "\n".join([*lines, "", where])
        print(text)
        if not quick:
            write_section(ROOT / "docs" / "reliability.md", self.name, text)
