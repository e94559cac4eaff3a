"""The compiled parts of learning: numba, imported only when first needed.

Machine code is kept in the user's cache folder, never beside the installed package.
"""

from __future__ import annotations

import os
from pathlib import Path

import numba

if not numba.config.CACHE_DIR:
    _caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    numba.config.CACHE_DIR = str(_caches / "evastudio" / "numba")
