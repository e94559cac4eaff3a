"""Arrays as bytes with their shapes and dtypes, for one column of the store."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from evastudio.errors import StorageError
from evastudio.world.snapshot import AnyArray

MOVING = "moving."
"""Begins the names of a snapshot's moving arrays, beside `states` and `actions`."""


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


def unpack_joined(parts: Sequence[bytes], what: str) -> dict[str, AnyArray]:
    """The arrays of all `parts`, one after the other along their leading axis.

    Parts that follow each other and are alike in everything but their numbers, as the chunks of a
    take are, are read together. Raises StorageError, naming `what`, for damaged bytes and parts
    that do not fit together.
    """
    read = []
    for (head, _), alike in itertools.groupby(parts, lambda part: (_head(part), len(part))):
        some = list(alike)
        first = unpack(some[0], what)  # what it finds sound in one holds of all
        read.append(first if len(some) == 1 else _unpack_alike(some, head, first))
    try:
        names = read[0] if read else ()
        return {name: np.concatenate([one[name] for one in read]) for name in names}
    except (KeyError, ValueError) as error:
        raise StorageError(
            f"The {what} is damaged: its parts do not fit together ({error})."
        ) from None


def _head(part: bytes) -> bytes:
    """What safetensors writes before the numbers: eight bytes of length, and JSON."""
    return part[: 8 + int.from_bytes(part[:8], "little")]


def _unpack_alike(
    parts: Sequence[bytes], head: bytes, first: Mapping[str, AnyArray]
) -> dict[str, AnyArray]:
    layout = json.loads(head[8:])
    rows = np.frombuffer(b"".join(parts), np.uint8).reshape(len(parts), -1)
    arrays = {}
    for name, one in first.items():
        begins, ends = (len(head) + offset for offset in layout[name]["data_offsets"])
        numbers = np.ascontiguousarray(rows[:, begins:ends]).reshape(-1).view(one.dtype)
        arrays[name] = numbers.reshape(-1, *one.shape[1:])
    return arrays
