"""One memory inside another: what a pilot remembers for the pilots that it asks."""

from __future__ import annotations

from evastudio.world.rollout import Memory


def named(prefix: str, memory: Memory) -> Memory:
    """`memory` with `prefix` before every name."""
    return {prefix + name: array for name, array in memory.items()}


def within(prefix: str, memory: Memory) -> Memory:
    """The part of `memory` whose names begin with `prefix`, under the names without it."""
    return {
        name.removeprefix(prefix): array
        for name, array in memory.items()
        if name.startswith(prefix)
    }
