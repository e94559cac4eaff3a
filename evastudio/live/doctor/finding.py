"""One thing that the doctor found."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Finding:
    """Something that a person should know of a workspace."""

    about: str
    """What it is about: a file, a take, the store."""
    problem: str
    """A sentence on what is so, and what to do where nothing can be mended."""
    mend: str | None = None
    """What mending does, or None where a person has to do something."""
    cure: Callable[[], object] | None = field(default=None, repr=False, compare=False)
    """Does it; raises StudioError or OSError."""
    wrong: bool = True
    """False for what is only worth knowing."""
    mended: bool = False

    def to_json(self) -> dict[str, Any]:
        names = ("about", "problem", "mend", "wrong", "mended")
        return {name: getattr(self, name) for name in names}


def move_aside(path: Path, root: Path) -> Path:
    """Move a file of the workspace `root` into its folder `aside`; where it is now."""
    inside = path.resolve().relative_to(root.resolve())
    for number in itertools.count():
        target = root / "aside" / inside
        if number:
            target = target.with_name(f"{inside.name}.{number}")
        if not target.exists():
            break
    target.parent.mkdir(parents=True, exist_ok=True)
    return path.rename(target)
