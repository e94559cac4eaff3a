"""Compile now what the studio would else compile beside itself."""

from __future__ import annotations

from evastudio.world.compiled import is_compiled


def ensure_compiled() -> None:
    """Compile now if need be: where a result must not depend on what was compiled before."""
    if not is_compiled():
        from evastudio.learning.kernels.warm import warm  # loads the compiler

        warm()
