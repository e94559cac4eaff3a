"""Random numbers that follow from a world's seed and step alone, for any batch of worlds.

A generator object would tie a world's luck to its neighbours in the batch; a counter does not.
The mixing function is SplitMix64 (Steele, Lea, Flood: "Fast splittable pseudorandom number
generators", 2014).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from evastudio.world.spaces import Array

Seeds = NDArray[np.uint64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def uniforms(seeds: Seeds, step: NDArray[np.int64], channel: int, count: int = 1) -> Array:
    """Numbers strictly between 0 and 1, shape (worlds, count), for `seeds` and `step` (worlds,).

    Each `channel` is another independent stream of the same world.
    """
    key = _mixed(seeds + np.uint64(channel * 0xD1B54A32D192ED03 % 2**64))
    key = _mixed(key ^ _mixed(step.astype(np.uint64) * _GOLDEN))
    words = _mixed(key[:, None] + (np.arange(count, dtype=np.uint64) + np.uint64(1)) * _GOLDEN)
    return np.asarray(((words >> np.uint64(11)).astype(np.float64) + 0.5) / 2.0**53)


def normals(seeds: Seeds, step: NDArray[np.int64], channel: int, count: int = 1) -> Array:
    """Standard normal numbers, otherwise as `uniforms`."""
    return np.asarray(ndtri(uniforms(seeds, step, channel, count)))


def _mixed(words: Seeds) -> Seeds:
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return words ^ (words >> np.uint64(31))
