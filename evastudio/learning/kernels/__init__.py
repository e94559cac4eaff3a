"""The compiled parts of learning: numba, imported only when first needed.

Machine code is kept in the user's cache folder, never beside the installed package.
"""

from __future__ import annotations

import numba

from evastudio.world.compiled import code_folder

numba.config.CACHE_DIR = str(code_folder())
