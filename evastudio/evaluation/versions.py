"""Which versions and machine a figure was made with."""

from __future__ import annotations

import hashlib
import platform
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

import evastudio

MATTER = ("evastudio", "numba", "numpy", "scikit-learn", "scipy")
"""Packages whose versions may change a figure's last digits."""


def versions() -> dict[str, str]:
    """Of Python and of the packages that figures depend on, in this process."""
    return {"python": platform.python_version(), **{name: version(name) for name in MATTER}}


@lru_cache(maxsize=1)
def code() -> str:
    """A digest of this package's modules: two checkouts of one version may differ."""
    root = Path(evastudio.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


def processor() -> str:
    """The processor's name, or the architecture where the system does not tell."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.machine()
