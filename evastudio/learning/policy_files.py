"""Policy files: one `.safetensors` file, arrays and a JSON header. Never a pickle.

The header's one metadata entry `evastudio` holds the JSON of `Policy.describe()` with the format
version and the state and action. Each learner says which arrays it needs and how they are written
(`Learner.layouts`); `moments` may stand beside them. The file is read here, and not by a library,
because every byte of a foreign file must be checked before use.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from evastudio.errors import InvalidInputError, StorageError
from evastudio.learning.learner import LARGEST, Indices, Layout, Learner, Stored
from evastudio.learning.policy import LEARNERS, Policy
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Box, Field, Space, Symbols
from evastudio.writing import write_whole

FORMAT = 3
"""Raised whenever older readers could not make sense of a file. 2 added the SVR's `bases`; 3
symbols, more learners, the pairs of an SVR and the moments that pairs were shown at."""
READABLE = (1, 2, FORMAT)
KEY = "evastudio"
SUFFIX = ".safetensors"
MOMENTS = "moments"
MAX_HEADER = 16_000_000
MAX_FILE = 2_000_000_000


def save_policy(policy: Policy, path: str | Path) -> Path:
    """Write `policy` to `path`, all of it or nothing. Returns the path.

    Raises StorageError where it cannot be written.
    """
    return write_whole(Path(path), policy_bytes(policy))


def policy_bytes(policy: Policy) -> bytes:
    """What the file of `policy` holds."""
    header = {
        "format": FORMAT,
        **policy.describe(),
        "state": _space_out(policy.state),
        "action": _space_out(policy.action),
    }
    learner = policy.learner
    layout = next(
        one for one in learner.layouts() if all(hasattr(learner, key + "_") for key in one)
    )
    arrays = {
        key: np.ascontiguousarray(getattr(learner, key + "_"), dtype=stored.dtype)
        for key, stored in layout.items()
    }
    if policy.moments is not None:
        narrow = np.min_scalar_type(int(policy.moments.max(initial=0)))
        arrays[MOMENTS] = np.ascontiguousarray(policy.moments, dtype=narrow)
    data: bytes = save(arrays, {KEY: json.dumps(header, allow_nan=False)})
    return data


def load_policy(path: str | Path) -> Policy:
    """The policy in `path`. Raises StorageError, saying what is wrong, for anything else."""
    path = Path(path)
    return parse_policy(_read(path, None), str(path))


def parse_policy(data: bytes, what: str) -> Policy:
    """The policy that the bytes of a file are. Raises StorageError, calling the file `what`."""
    header = _header(what, data)
    try:
        arrays: dict[str, AnyArray] = load(data)
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError) as error:
        _damaged(what, f"its arrays cannot be read ({error})")
    try:
        return _policy(header, arrays)
    except InvalidInputError as error:
        _damaged(what, str(error))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        _damaged(what, f"its description is not whole ({type(error).__name__}: {error})")


def read_policy_header(path: str | Path) -> dict[str, Any]:
    """What a policy file says about itself, without its arrays: cheap, for listings.

    The dict of `Policy.describe()` with `format`, `state` and `action`. Raises StorageError.
    """
    path = Path(path)
    start = _read(path, 8)
    length = int.from_bytes(start[:8], "little")
    if len(start) < 8 or length > MAX_HEADER:
        _damaged(str(path), "it does not begin as a policy file does")
    return _header(str(path), _read(path, 8 + length))


def _read(path: Path, size: int | None) -> bytes:
    try:
        if path.stat().st_size > MAX_FILE:
            _damaged(str(path), f"it is larger than {MAX_FILE // 1_000_000} MB")
        with path.open("rb") as file:
            return file.read() if size is None else file.read(size)
    except OSError as error:
        raise StorageError(
            f"The policy file {path} could not be read: {error.strerror}. Check the name; "
            "policies end in .safetensors."
        ) from None


def _damaged(what: str, reason: str) -> NoReturn:
    raise StorageError(
        f"{what} is not a policy that can be used: {reason}. It may be damaged, cut short or "
        "made by another program; fit the policy again or take a fresh copy."
    )


def _header(what: str, data: bytes) -> dict[str, Any]:
    length = int.from_bytes(data[:8], "little")
    if len(data) < 8 or length > MAX_HEADER or len(data) < 8 + length:
        _damaged(what, "it is too short, or does not begin as a policy file does")
    try:
        outer = json.loads(data[8 : 8 + length].decode("utf-8"))
        header = json.loads(outer["__metadata__"][KEY])
        json.dumps(header, ensure_ascii=False).encode()  # half a letter cannot be told to a page
        version = header["format"]
    except (ValueError, KeyError, TypeError, RecursionError):
        _damaged(what, "it does not describe an EVA Studio policy")
    if isinstance(version, int) and version > FORMAT:
        raise StorageError(
            f"{what} has policy format {version}, and this studio reads up to {FORMAT}. "
            "Install a newer EVA Studio to use it."
        )
    if version not in READABLE:
        _damaged(what, f"its format is {version!r}, expected {FORMAT}")
    return dict(header)


def _policy(header: dict[str, Any], arrays: dict[str, AnyArray]) -> Policy:
    state, action = _space_in(header["state"]), _space_in(header["action"])
    if not isinstance(state, Box):
        raise InvalidInputError("its state is not made of numbers")
    scene = header["scene"]
    if not isinstance(scene["name"], str) or not isinstance(scene["version"], int):
        raise InvalidInputError("the scene it names has no name or version")
    if not isinstance(scene["options"], dict):
        raise InvalidInputError("the options of its scene are not listed")
    takes = tuple(int(take) for take in header["takes"])
    for name in ("perception", "fingerprint", "made_by", "created"):
        if not isinstance(header[name], str):
            raise InvalidInputError(f"its entry {name!r} is not text")
    if not isinstance(header["session"], int | str | None):
        raise InvalidInputError("its entry 'session' is no number or name")
    for name in ("cleaning", "evaluation"):
        if header[name] is not None and not isinstance(header[name], dict):
            raise InvalidInputError(f"its entry {name!r} is not a report")
    moments = arrays.pop(MOMENTS, None)
    learner = _learner(header, arrays, state, action)
    return Policy(
        learner=learner,
        scene=scene,
        perception=header["perception"],
        state=state,
        action=action,
        pairs=int(header["pairs"]),
        fingerprint=header["fingerprint"],
        session=header["session"],
        takes=takes,
        cleaning=header["cleaning"],
        evaluation=header["evaluation"],
        moments=None if moments is None else _moments(moments, len(learner.kept)),
        made_by=header["made_by"],
        created=header["created"],
        extra=dict(header["extra"]),
    )


def _learner(
    header: dict[str, Any], arrays: dict[str, AnyArray], state: Box, action: Space
) -> Learner:
    """The learner as it was fitted, every array checked for shape and finite values."""
    name = header["learner"]
    if name not in LEARNERS:
        raise InvalidInputError(f"its learner {name!r} is not known here")
    learner = LEARNERS[name]()
    if not isinstance(action, learner.acts_in):
        raise InvalidInputError(f"its learner {name!r} cannot give such an action")
    settings = dict(header["settings"])
    if header["format"] == 1 and name == "svr":
        settings.setdefault("bases", None)
    if set(settings) != set(learner.get_params()):
        raise InvalidInputError("its settings are not those of its learner")
    learner.set_params(**settings)
    learner.check_settings()
    sizes = {"states": state.size, "actions": len(action.names)}
    for key, stored in _layout(learner, arrays).items():
        setattr(learner, key + "_", _checked(key, arrays[key], stored, sizes))
    learner.check_fitted()
    learner.n_features_in_ = state.size
    learner.flat_ = False
    return learner.prepare()


def _layout(learner: Learner, arrays: dict[str, AnyArray]) -> Layout:
    """Which of the layouts of `learner` the arrays are."""
    for layout in learner.layouts():
        if set(layout) == set(arrays):
            return layout
    raise InvalidInputError(
        f"it holds the arrays {sorted(arrays)}, not {sorted(learner.layouts()[0])}"
    )


def _checked(key: str, array: AnyArray, stored: Stored, sizes: dict[str, int]) -> AnyArray:
    """`array`, widened; `sizes` learns the count of every axis that it is the first to have."""
    if array.dtype != stored.dtype:
        raise InvalidInputError(f"its array {key!r} holds {array.dtype} numbers")
    if array.size * 8 > MAX_FILE:
        raise InvalidInputError(f"its array {key!r} is too large")
    if array.ndim == len(stored.shape):
        for axis, count in zip(stored.shape, array.shape, strict=True):
            sizes.setdefault(axis, count)
    expected = tuple(sizes[axis] for axis in stored.shape if axis in sizes)
    if array.shape != expected:
        raise InvalidInputError(f"its array {key!r} has shape {array.shape}, expected {expected}")
    wide = array.astype(np.int64 if np.issubdtype(array.dtype, np.signedinteger) else np.float64)
    if not ((wide >= stored.low) & (wide <= LARGEST)).all():
        raise InvalidInputError(f"its array {key!r} holds values that make no sense")
    return wide


def _moments(array: AnyArray, count: int) -> Indices:
    """Take and step of `count` pairs."""
    if not np.issubdtype(array.dtype, np.unsignedinteger) or array.shape != (count, 2):
        raise InvalidInputError(f"its {MOMENTS} are not a take and a step for each of its pairs")
    return array.astype(np.int64)


def _space_out(space: Space) -> Any:
    if isinstance(space, Symbols):
        return {"symbols": list(space.names)}
    return [
        {
            "name": field.name,
            "unit": field.unit,
            "low": field.low if math.isfinite(field.low) else None,
            "high": field.high if math.isfinite(field.high) else None,
        }
        for field in space.fields
    ]


def _space_in(entries: Any) -> Space:
    if isinstance(entries, dict):
        return Symbols(tuple(entries["symbols"]))
    fields = []
    for entry in entries:
        name, unit, low, high = entry["name"], entry["unit"], entry["low"], entry["high"]
        if not isinstance(name, str) or not isinstance(unit, str):
            raise InvalidInputError("a field of its state or action has no name or unit")
        low = -math.inf if low is None else float(low)
        high = math.inf if high is None else float(high)
        fields.append(Field(name, unit, low, high))
    if not fields:
        raise InvalidInputError("its state or action has no fields")
    return Box(tuple(fields))
