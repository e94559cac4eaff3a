"""Arrays over HTTP: as JSON, as NumPy's npz, as CSV; what comes in is checked byte by byte."""

from __future__ import annotations

import csv
import io
import json
import math
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from evastudio.errors import InvalidInputError
from evastudio.world.snapshot import AnyArray

NPZ = "application/x-npz"
CSV = "text/csv"
JSON = "application/json"
MOST_BYTES = 256_000_000
"""Of arrays that come in, unpacked."""
MOST_ARRAYS = 200
MOST_AXES = 8
MAGIC = b"\x93NUMPY"


def npz(arrays: Mapping[str, AnyArray]) -> bytes:
    """`arrays` as `numpy.load` reads them; equal bytes for equal arrays."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: np.asarray(one) for name, one in arrays.items()})
    return buffer.getvalue()


def read_npz(data: bytes, most_bytes: int = MOST_BYTES) -> dict[str, AnyArray]:
    """The arrays of numbers in an npz file. Nothing in it is executed or trusted.

    Raises InvalidInputError for anything else, and for more than `most_bytes` when unpacked.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if len(members) > MOST_ARRAYS:
                raise _bad(f"it holds {len(members)} arrays, and {MOST_ARRAYS} are read at most")
            if sum(member.file_size for member in members) > most_bytes:
                raise _bad(f"unpacked it is larger than {most_bytes // 1_000_000} MB")
            return {
                member.filename.removesuffix(".npy"): _array(
                    _unpacked(archive, member), member.filename
                )
                for member in members
            }
    except InvalidInputError:
        raise
    except Exception as error:  # zipfile raises a dozen kinds for what is no archive
        raise _bad(f"it cannot be unpacked ({type(error).__name__})") from None


def _unpacked(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """As much of `member` as it says it has: `archive.read` would unpack all that there is."""
    with archive.open(member) as file:
        return file.read(member.file_size)


def _array(data: bytes, name: str) -> AnyArray:
    file = io.BytesIO(data)
    shown = name[:80]
    try:
        version = np.lib.format.read_magic(file)
        read = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[version]
        shape, columns_first, dtype = read(file)
    except Exception:  # whatever a made-up header provokes
        raise _bad(f"{shown!r} is no array") from None
    if dtype.kind not in "fiub" or len(shape) > MOST_AXES or min(shape, default=0) < 0:
        raise _bad(f"{shown!r} is no array of plain numbers")
    rest = len(data) - file.tell()
    if math.prod(shape) * dtype.itemsize != rest:
        raise _bad(f"{shown!r} does not hold as many numbers as it says")
    flat = np.frombuffer(data, dtype, offset=file.tell())
    return flat.reshape(shape, order="F" if columns_first else "C")


def _bad(reason: str) -> InvalidInputError:
    return InvalidInputError(
        f"These are not arrays that can be used: {reason}. Send what numpy.savez writes."
    )


def as_json(content: Mapping[str, Any]) -> bytes:
    """`content` with its arrays as lists; numbers that are not finite become null."""
    return json.dumps(_plain(content), allow_nan=False).encode()


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            return _plain(value.tolist())
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def as_csv(columns: Sequence[str], *parts: AnyArray) -> bytes:
    """A table of `columns`, made of (rows,) and (rows, n) arrays side by side."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(columns)
    flat = [part[:, None] if part.ndim == 1 else part for part in parts]
    lists = [part.tolist() for part in flat]
    for row in zip(*lists, strict=True):
        writer.writerow([number for part in row for number in part])
    return text.getvalue().encode()
