"""A batch of headless worlds as it is kept in a file: everything that it takes to go on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evastudio.errors import InvalidInputError
from evastudio.world.snapshot import AnyArray, Snapshot

ABOUT = "about"
FIXED, MOVING, MEMORY = "fixed.", "moving.", "memory."


@dataclass(frozen=True)
class Saved:
    """Worlds at a moment, what they are of, and the pilot that was acting in them."""

    scene: Mapping[str, Any]
    """The scene's `identity`."""
    seeds: tuple[int, ...]
    steps: NDArray[np.int64]
    """Decisions taken in each, (worlds,)."""
    snapshot: Snapshot
    pilot: str | None = None
    memory: Mapping[str, AnyArray] | None = None
    """What the pilot remembers of the worlds that go on."""

    def arrays(self, *, fixed: bool = False) -> dict[str, AnyArray]:
        """As arrays by name; `about` holds JSON as bytes.

        With what is `fixed` where that is wanted; it follows from the seeds, and may be large.
        """
        about = json.dumps({"scene": self.scene, "pilot": self.pilot})
        named = {
            FIXED: self.snapshot.fixed if fixed else {},
            MOVING: self.snapshot.moving,
            MEMORY: self.memory or {},
        }
        return {
            ABOUT: np.frombuffer(about.encode(), dtype=np.uint8),
            "seeds": np.array(self.seeds, dtype=np.int64),
            "steps": self.steps,
            **{
                before + name: array
                for before, part in named.items()
                for name, array in part.items()
            },
        }

    @classmethod
    def of(cls, arrays: Mapping[str, AnyArray]) -> Saved:
        """What `arrays` hold. Raises InvalidInputError for what no batch was ever saved as."""
        try:
            about = json.loads(arrays[ABOUT].tobytes().decode())
            scene, pilot = dict(about["scene"]), about["pilot"]
            seeds, steps = arrays["seeds"], arrays["steps"]
        except (KeyError, ValueError, TypeError, RecursionError) as error:
            raise InvalidInputError(
                "The file is no snapshot of headless worlds (it lacks what it is about). Give one "
                "as it was downloaded."
            ) from error
        if not (pilot is None or isinstance(pilot, str)):
            raise InvalidInputError("The snapshot names a pilot that is no name.")
        rows = _whole(seeds, "seeds")
        return cls(
            scene,
            tuple(int(seed) for seed in rows),
            _whole(steps, "steps", len(rows)),
            Snapshot(_part(arrays, FIXED), _part(arrays, MOVING)),
            pilot,
            _part(arrays, MEMORY),
        )


def checked_like(
    given: Mapping[str, AnyArray], like: Mapping[str, AnyArray], what: str
) -> dict[str, AnyArray]:
    """`given`, where its arrays have the names, shapes and dtypes of `like` and are finite.

    Raises InvalidInputError, naming `what` and the first array that differs.
    """
    if set(given) != set(like):
        odd = sorted(set(given) ^ set(like))[0]
        raise InvalidInputError(
            f"The {what} {'lacks' if odd in like else 'has an unknown array'} {odd!r}; expected "
            f"{', '.join(sorted(like)) or 'none'}."
        )
    for name, array in like.items():
        found = given[name]
        if (found.shape, found.dtype) != (array.shape, array.dtype):
            raise InvalidInputError(
                f"The array {name!r} of the {what} has shape {found.shape} and dtype "
                f"{found.dtype}; expected {array.shape} and {array.dtype}."
            )
        if found.dtype.kind == "f" and not np.isfinite(found).all():
            raise InvalidInputError(
                f"The array {name!r} of the {what} holds NaN or infinite numbers."
            )
    return dict(given)


def _part(arrays: Mapping[str, AnyArray], prefix: str) -> dict[str, AnyArray]:
    return {
        name.removeprefix(prefix): array
        for name, array in arrays.items()
        if name.startswith(prefix)
    }


def _whole(values: AnyArray, what: str, count: int | None = None) -> NDArray[np.int64]:
    """`values` as a row of whole numbers from 0 on, `count` of them where it is given."""
    if values.dtype != np.int64 or values.ndim != 1 or count not in (None, len(values)):
        raise InvalidInputError(
            f"The {what} of the snapshot have shape {values.shape} and dtype {values.dtype}; "
            f"expected one int64 for each world."
        )
    if (values < 0).any():
        raise InvalidInputError(f"The {what} of the snapshot are negative.")
    return values
