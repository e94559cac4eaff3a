"""Which versions a figure was made with."""

from __future__ import annotations

import platform
from importlib.metadata import version

MATTER = ("evastudio", "numba", "numpy", "scikit-learn", "scipy")
"""Packages whose versions may change a figure's last digits."""


def versions() -> dict[str, str]:
    """Of Python and of the packages that figures depend on, in this process."""
    return {"python": platform.python_version(), **{name: version(name) for name in MATTER}}
