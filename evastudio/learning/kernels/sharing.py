"""Work shared among all processors.

Kernels give up Python's lock, so plain threads do: unlike numba's own they may be started by
several callers at once, wait without burning time, and cost nothing to load.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from numba import config

THREADS: int = config.NUMBA_NUM_THREADS
"""As many as there are processors to use, or what the environment says."""


def share(count: int, step: int, work: Callable[[int, int], object]) -> None:
    """work(first, last) for all of `count`, `step` at a time, by whoever is free."""
    if count <= step or THREADS == 1:
        work(0, count)
        return
    starts = iter(range(0, count, step))

    def take() -> None:
        for first in starts:
            work(first, min(first + step, count))

    with ThreadPoolExecutor(THREADS - 1) as pool:
        helpers = [pool.submit(take) for _ in range(THREADS - 1)]
        take()
        for helper in helpers:
            helper.result()
