"""Policy files: one `.safetensors` file, arrays and a JSON header. Never a pickle.

The header's one metadata entry `evastudio` holds the JSON of `Policy.describe()` with the format
version and the state and action fields. Arrays are float64 (indices int64), those of a compact
SVR narrower. The file is read here, and not by a library, because every byte of a foreign file
must be checked before use.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from evastudio.errors import InvalidInputError, StorageError
from evastudio.learning.knn import KNNPolicy
from evastudio.learning.policy import LEARNERS, Learner, Policy
from evastudio.learning.svr import SVRPolicy
from evastudio.world.snapshot import AnyArray
from evastudio.world.spaces import Box, Field

FORMAT = 2
"""Raised whenever older readers could not make sense of a file. 2 added the SVR's `bases`."""
READABLE = (1, FORMAT)
KEY = "evastudio"
SUFFIX = ".safetensors"
MAX_HEADER = 16_000_000
MAX_FILE = 2_000_000_000
LARGEST = 1e60
"""No number of a policy is beyond this, so that no decision overflows."""

ARRAYS: Mapping[str, tuple[str, ...]] = {
    "knn": ("states_", "actions_", "offset_", "scale_"),
    "svr": (
        "support_",
        "support_vectors_",
        "coefficients_",
        "intercept_",
        "offset_",
        "scale_",
    ),
}
"""The fitted attributes that make each learner whole."""

NARROW: Mapping[str, type[np.generic]] = {
    "support": np.int32,
    "support_vectors": np.float16,
    "coefficients": np.float32,
}
"""How a compact SVR is stored; it is made of numbers that lose nothing by it."""


def save_policy(policy: Policy, path: str | Path) -> Path:
    """Write `policy` to `path`, all of it or nothing. Returns the path.

    Raises StorageError where it cannot be written.
    """
    path = Path(path)
    header = {
        "format": FORMAT,
        **policy.describe(),
        "state": _fields_out(policy.state),
        "action": _fields_out(policy.action),
    }
    arrays = {}
    for name in ARRAYS[policy.learner_name]:
        key = name.rstrip("_")
        dtype = _stored_as(policy.learner, key)
        arrays[key] = np.ascontiguousarray(getattr(policy.learner, name), dtype=dtype)
    data = save(arrays, {KEY: json.dumps(header, allow_nan=False)})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            Path(temporary).replace(path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise StorageError(
            f"The policy could not be written to {path}: {error.strerror}. Choose a folder that "
            "exists, has room and may be written to."
        ) from None
    return path


def _stored_as(learner: Learner, key: str) -> type[np.generic]:
    """The kind of number that array `key` of `learner` is stored as."""
    if isinstance(learner, SVRPolicy) and learner.bases is not None and key in NARROW:
        return NARROW[key]
    return np.int64 if key == "support" else np.float64


def load_policy(path: str | Path) -> Policy:
    """The policy in `path`. Raises StorageError, saying what is wrong, for anything else."""
    path = Path(path)
    data = _read(path, None)
    header = _header(path, data)
    try:
        arrays: dict[str, AnyArray] = load(data)
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError) as error:
        _damaged(path, f"its arrays cannot be read ({error})")
    try:
        return _policy(header, arrays)
    except InvalidInputError as error:
        _damaged(path, str(error))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        _damaged(path, f"its description is not whole ({type(error).__name__}: {error})")


def read_policy_header(path: str | Path) -> dict[str, Any]:
    """What a policy file says about itself, without its arrays: cheap, for listings.

    The dict of `Policy.describe()` with `format`, `state` and `action`. Raises StorageError.
    """
    path = Path(path)
    start = _read(path, 8)
    length = int.from_bytes(start[:8], "little")
    if len(start) < 8 or length > MAX_HEADER:
        _damaged(path, "it does not begin as a policy file does")
    return _header(path, _read(path, 8 + length))


def _read(path: Path, size: int | None) -> bytes:
    try:
        if path.stat().st_size > MAX_FILE:
            _damaged(path, f"it is larger than {MAX_FILE // 1_000_000} MB")
        with path.open("rb") as file:
            return file.read() if size is None else file.read(size)
    except OSError as error:
        raise StorageError(
            f"The policy file {path} could not be read: {error.strerror}. Check the name; "
            "policies end in .safetensors."
        ) from None


def _damaged(path: Path, reason: str) -> NoReturn:
    raise StorageError(
        f"{path} is not a policy that can be used: {reason}. It may be damaged, cut short or "
        "made by another program; fit the policy again or take a fresh copy."
    )


def _header(path: Path, data: bytes) -> dict[str, Any]:
    length = int.from_bytes(data[:8], "little")
    if len(data) < 8 or length > MAX_HEADER or len(data) < 8 + length:
        _damaged(path, "it is too short, or does not begin as a policy file does")
    try:
        outer = json.loads(data[8 : 8 + length].decode("utf-8"))
        header = json.loads(outer["__metadata__"][KEY])
        version = header["format"]
    except (ValueError, KeyError, TypeError, RecursionError):
        _damaged(path, "it does not describe an EVA Studio policy")
    if isinstance(version, int) and version > FORMAT:
        raise StorageError(
            f"{path} has policy format {version}, and this studio reads up to {FORMAT}. "
            "Install a newer EVA Studio to use it."
        )
    if version not in READABLE:
        _damaged(path, f"its format is {version!r}, expected {FORMAT}")
    return dict(header)


def _policy(header: dict[str, Any], arrays: dict[str, AnyArray]) -> Policy:
    state, action = _fields_in(header["state"]), _fields_in(header["action"])
    scene = header["scene"]
    if not isinstance(scene["name"], str) or not isinstance(scene["version"], int):
        raise InvalidInputError("the scene it names has no name or version")
    if not isinstance(scene["options"], dict):
        raise InvalidInputError("the options of its scene are not listed")
    takes = tuple(int(take) for take in header["takes"])
    for name in ("perception", "fingerprint", "made_by", "created"):
        if not isinstance(header[name], str):
            raise InvalidInputError(f"its entry {name!r} is not text")
    for name in ("cleaning", "evaluation"):
        if header[name] is not None and not isinstance(header[name], dict):
            raise InvalidInputError(f"its entry {name!r} is not a report")
    return Policy(
        learner=_learner(header, arrays, state.size, action.size),
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
        made_by=header["made_by"],
        created=header["created"],
        extra=dict(header["extra"]),
    )


def _learner(
    header: dict[str, Any], arrays: dict[str, AnyArray], states: int, actions: int
) -> Learner:
    """The learner as it was fitted, every array checked for shape and finite values."""
    name = header["learner"]
    if name not in LEARNERS:
        raise InvalidInputError(f"its learner {name!r} is not known here")
    learner: Any = LEARNERS[name]()
    settings = dict(header["settings"])
    if header["format"] == 1 and name == "svr":
        settings.setdefault("bases", None)
    if set(settings) != set(learner.get_params()):
        raise InvalidInputError("its settings are not those of its learner")
    learner.set_params(**settings)
    wanted = {attribute.rstrip("_") for attribute in ARRAYS[name]}
    if set(arrays) != wanted:
        raise InvalidInputError(f"it holds the arrays {sorted(arrays)}, not {sorted(wanted)}")
    for key, array in arrays.items():
        if array.dtype != _stored_as(learner, key):
            raise InvalidInputError(f"its array {key!r} holds {array.dtype} numbers")
        wide = array.astype(np.int64 if key == "support" else np.float64)
        if not (np.abs(wide) < LARGEST).all():
            raise InvalidInputError(f"its array {key!r} holds values that make no sense")
        setattr(learner, key + "_", wide)
    rows = len(arrays["states" if name == "knn" else "support_vectors"])
    shapes: dict[str, tuple[int, ...]] = {"offset": (states,), "scale": (states,)}
    shapes |= {"intercept": (actions,)}
    shapes |= {"states": (rows, states), "actions": (rows, actions), "support": (rows,)}
    shapes |= {"support_vectors": (rows, states), "coefficients": (rows, actions)}
    for key, array in arrays.items():
        if array.shape != shapes[key]:
            raise InvalidInputError(
                f"its array {key!r} has shape {array.shape}, expected {shapes[key]}"
            )
    if not (arrays["scale"] > 1.0 / LARGEST).all():
        raise InvalidInputError("its standardisation divides by zero")
    if isinstance(learner, KNNPolicy):
        learner.check_settings()
        if learner.k > rows:
            raise InvalidInputError(f"it decides from {learner.k} pairs and holds {rows}")
    if isinstance(learner, SVRPolicy):
        learner.check_settings()
    learner.n_features_in_ = states
    learner.flat_ = False
    learner.prepare()
    return learner  # type: ignore[no-any-return]


def _fields_out(box: Box) -> list[dict[str, Any]]:
    return [
        {
            "name": field.name,
            "unit": field.unit,
            "low": field.low if math.isfinite(field.low) else None,
            "high": field.high if math.isfinite(field.high) else None,
        }
        for field in box.fields
    ]


def _fields_in(entries: Any) -> Box:
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
