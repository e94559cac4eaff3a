"""Arrays as bytes with their shapes and dtypes, for one column of the store."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from evastudio.errors import StorageError
from evastudio.world.snapshot import AnyArray


def pack(arrays: Mapping[str, AnyArray]) -> bytes:
    """`arrays` in the safetensors format."""
    packed: bytes = save({name: np.ascontiguousarray(array) for name, array in arrays.items()})
    return packed


def unpack(data: bytes, what: str) -> dict[str, AnyArray]:
    """The arrays of `data`. Raises StorageError, naming `what`, for damaged bytes."""
    try:
        arrays: dict[str, AnyArray] = load(data)
    except (SafetensorError, ValueError, KeyError) as error:
        raise StorageError(f"The {what} is damaged and cannot be read ({error}).") from None
    return arrays
