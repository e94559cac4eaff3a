"""The compiled parts of pilots: numba, imported only when first needed."""

from __future__ import annotations

import evastudio.learning.kernels  # noqa: F401 - says where machine code is kept
